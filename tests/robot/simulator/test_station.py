"""The whole simulated robot as a user starts it: sockets, a pseudo terminal, HTTP, signals."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import serial

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Decoder, Packet
from facetlog.robot.simulator.serving import web
from facetlog.robot.simulator.serving.endpoints import PtyEndpoint
from facetlog.robot.simulator.simulation import Simulation
from facetlog.robot.simulator.station import ActiveClient
from facetlog.robot.simulator.world_file import HeadSetup, WorldSetup
from tests.patience import allowed
from tests.robot.simulator.running import ANYWHERE, LONG, SETUP, SMALL, Running, until


class Caller:
    """A client over functions that write and read bytes."""

    def __init__(self, write: Callable[[bytes], object], read: Callable[[], bytes]) -> None:
        self.write, self.read = write, read
        self.decoder = Decoder()

    def ask(self, packet: Packet, kind: int) -> Packet:
        self.write(packet.to_bytes())
        return self.next(kind)

    def next(self, kind: int) -> Packet:
        def found() -> Packet | None:
            came = [received.packet for received in self.decoder.feed(self.read())]
            return next((packet for packet in came if packet.kind == kind), None)

        return until(found, f"a packet of kind {kind:#x}")  # type: ignore[no-any-return]

    def connect(self) -> None:
        for number in range(3):
            self.ask(Packet(number), number)
        self.ask(make_plain_command(Command.OPEN), 0x32)
        self.write(make_integer_command(Command.ENABLE, 1).to_bytes())


def over_tcp(running: Running) -> tuple[Caller, socket.socket]:
    host, port = running.station.addresses.robot.removeprefix("tcp:").split(":")
    line = socket.create_connection((host, int(port)), timeout=allowed(LONG))
    return Caller(line.sendall, lambda: line.recv(4096)), line


@pytest.fixture
def running() -> Iterator[Running]:
    made = Running()
    yield made
    made.close()


def test_a_client_drives_over_tcp_and_the_state_shows_it(running: Running) -> None:
    client, line = over_tcp(running)
    with line:
        client.connect()
        client.write(make_integer_command(Command.VEL, 200).to_bytes())
        client.next(0x33)
        until(lambda: running.state()["truth"]["x"] > 0.05, "motion")
        state = running.state()
    assert state["session"]
    assert state["motors"]
    assert state["truth"]["x"] == pytest.approx(state["odometry"]["x"], abs=0.01)
    assert set(state) >= {"schema", "at", "speed", "turning", "pan", "tilt", "zoom", "stalled"}


def test_a_client_drives_over_a_pseudo_terminal_at_two_speeds() -> None:
    running = Running(pty=True)
    try:
        path = running.station.addresses.pty
        with serial.Serial(path, 9600, timeout=0.1) as line:
            client = Caller(line.write, lambda: bytes(line.read(200)))
            line.write(b"WMS2\r")
            client.connect()
            client.write(make_integer_command(Command.HOSTBAUD, 2).to_bytes())
            line.flush()
            time.sleep(0.05)
            line.baudrate = 38400
            client.ask(make_plain_command(Command.PULSE), 0x32)
            client.ask(make_integer_command(Command.VEL, 200), 0x33)
            # After a client that falls silent at the new speed it stays there.
            time.sleep(0.7)
            client.next(0x33)
            client.write(make_plain_command(Command.CLOSE).to_bytes())
    finally:
        running.close()


def test_another_end_is_heard_once_the_first_one_is_silent() -> None:
    first, second = (PtyEndpoint(np.random.default_rng(0)) for _ in range(2))
    try:
        turn = ActiveClient([first, second])
        assert turn.takes(second, 0.0, 2.0)
        assert not turn.takes(first, 1.9, 2.0)
        assert turn.takes(second, 2.0, 2.0)
        assert not turn.takes(first, 3.9, 2.0)
        assert turn.end is second
        assert turn.takes(first, 4.1, 2.0)
        assert turn.end is first
    finally:
        first.close()
        second.close()


def test_a_new_speed_of_the_line_is_given_up_without_a_valid_packet() -> None:
    simulation = Simulation(SETUP)
    for number in range(3):
        simulation.receive(Packet(number).to_bytes(), 0.1 * number)
    simulation.receive(make_plain_command(Command.OPEN).to_bytes(), 0.3)
    simulation.receive(make_integer_command(Command.HOSTBAUD, 2).to_bytes(), 1.0)
    simulation.advance(1.4)
    assert simulation.firmware.baud == 38400
    simulation.receive(b"\x00\xff junk", 1.45)
    simulation.advance(1.6)
    assert simulation.firmware.baud == 9600
    simulation.receive(make_integer_command(Command.HOSTBAUD, 2).to_bytes(), 2.0)
    simulation.receive(make_plain_command(Command.PULSE).to_bytes(), 2.3)
    simulation.advance(9.0)
    assert simulation.firmware.baud == 38400


def test_a_head_with_a_port_of_its_own_is_reached_over_tcp_and_a_terminal() -> None:
    for own in (ANYWHERE, "pty"):
        running = Running(WorldSetup(head=HeadSetup(port="own", own=own), camera=SMALL))
        try:
            address = running.station.addresses.head
            if own == "pty":
                line: Any = serial.Serial(address, 9600, timeout=allowed(LONG))
                read, write = line.read, line.write
            else:
                host, port = address.removeprefix("tcp:").split(":")
                line = socket.create_connection((host, int(port)), timeout=allowed(LONG))
                read, write = line.recv, line.sendall
            with line:
                write(bytes.fromhex("81 09 06 12 FF"))
                answers = b""
                while answers.count(b"\xff") < 2:
                    answers += read(1)
            # that it has been switched on, and that it looks straight ahead
            assert answers == bytes.fromhex("90 38 FF 90 50 00 00 00 00 00 00 00 00 FF")
        finally:
            running.close()


def test_a_still_is_exposed_after_its_request(running: Running) -> None:
    before = running.picture()
    client, line = over_tcp(running)
    with line:
        client.connect()
        client.write(make_integer_command(Command.RVEL, 60).to_bytes())
        until(lambda: running.state()["truth"]["heading"] > 0.6, "the turn")
        client.write(make_integer_command(Command.RVEL, 0).to_bytes())
        until(lambda: running.state()["turning"] == 0.0, "a stand")
        after = running.picture()
        again = running.picture()
    moved = np.abs(after.astype(float) - before).mean()
    rest = np.abs(after.astype(float) - again).mean()
    assert moved > 2 * rest


def test_a_frozen_camera_repeats_its_picture_and_a_silent_one_sends_none(
    running: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    running.picture()
    running.fault(kind="camera-frozen")
    running.picture()
    assert np.array_equal(running.picture(), running.picture())
    running.fault(kind="camera-frozen", on=False)
    assert not np.array_equal(running.picture(), running.picture())
    running.fault(kind="camera-silent")
    monkeypatch.setattr(web, "STILL_SECONDS", 0.3)
    with pytest.raises(urllib.error.HTTPError) as refused:
        running.get(running.station.addresses.still)
    with refused.value:
        assert refused.value.code == 503
        assert b"the camera sends no picture" in refused.value.read()


@pytest.mark.slow
def test_the_camera_goes_on_after_its_process_was_killed(
    running: Running, caplog: pytest.LogCaptureFixture
) -> None:
    running.picture()
    process = running.station.camera_process
    assert process is not None
    os.kill(process, signal.SIGKILL)
    picture = until(lambda: (found := running.get_picture_or_none()) is not None and [found], "one")
    assert picture[0].shape == (120, 160)
    assert running.station.camera_process != process
    assert "it is started again" in caplog.text


def test_faults_are_ordered_over_http_and_wrong_orders_refused(running: Running) -> None:
    answer = running.fault(kind="low-battery", volts=10.0)
    assert answer["fault"]["kind"] == "low-battery"
    assert running.state()["battery_v"] == 10.0
    for wrong in ({"kind": "fire"}, {"kind": "lost", "rate": 3}, {"kind": "lost", "speed": 1}, {}):
        with pytest.raises(urllib.error.HTTPError) as refused:
            running.fault(**wrong)
        with refused.value:
            assert refused.value.code == 400
            assert "error" in json.loads(refused.value.read())
    with pytest.raises(urllib.error.HTTPError) as missing:
        running.get(running.station.addresses.state + "s")
    with missing.value:
        assert missing.value.code == 404


def test_a_number_that_is_none_is_refused_in_one_line(running: Running) -> None:
    for name, number in (("seconds", "1e400"), ("delay", "NaN"), ("volts", "Infinity")):
        body = f'{{"kind": "frozen", "{name}": {number}}}'
        request = urllib.request.Request(  # noqa: S310 - loopback
            running.station.addresses.faults, data=body.encode()
        )
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(request, timeout=allowed(LONG))  # noqa: S310
        with refused.value:
            assert refused.value.code == 400
            error = json.loads(refused.value.read())["error"]
        assert error.startswith(f"{name}: "), error
        assert "\n" not in error


def command(*arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "facetlog", "simulate", "--camera", ANYWHERE, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_the_command_prints_its_addresses_and_ends_cleanly() -> None:
    with command("--listen", ANYWHERE, "--pty", "--json", "--seed", "3") as process:
        assert process.stdout is not None
        told = json.loads(process.stdout.readline())
        assert told["robot"].startswith("tcp:127.0.0.1:")
        assert Path(told["pty"]).exists()
        assert told["head"] == "aux1"
        with urllib.request.urlopen(told["state"], timeout=allowed(LONG)) as answer:  # noqa: S310
            assert json.loads(answer.read())["truth"]["x"] == 0.0
        with urllib.request.urlopen(told["camera"], timeout=allowed(LONG)) as stream:  # noqa: S310
            assert stream.read(10), "a picture is under way"
            process.send_signal(signal.SIGTERM)
            assert process.wait(allowed(LONG)) == 0
        assert process.stderr is not None
        assert process.stderr.read() == ""


def test_a_port_in_use_ends_the_command_with_one_line_and_3() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with command("--listen", address) as process:
            out, error = process.communicate(timeout=allowed(LONG))
    assert process.returncode == 3
    assert out == ""
    assert error.splitlines() == [
        f"facetlog: {address} is in use: end what listens there, or give another --listen"
    ]
