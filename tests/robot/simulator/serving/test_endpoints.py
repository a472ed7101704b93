"""Ends of lines: one TCP client at a time, and a pseudo terminal that minds its speed."""

import socket
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import serial

from facetlog.errors import DeviceError, InputError
from facetlog.robot.simulator.serving.endpoints import (
    UNDER_WAY,
    PtyEndpoint,
    TcpEndpoint,
    split_host_and_port,
)
from tests.patience import allowed

OPTION = "--listen"
BAUD = 9600


def eventually(found: Callable[[], object]) -> object:
    """What `found` gives once it is true; fails if it never is."""
    deadline = time.monotonic() + allowed(10.0)
    while time.monotonic() < deadline:
        if value := found():
            return value
        time.sleep(0.005)
    pytest.fail("it did not happen")


@pytest.fixture
def tcp() -> Iterator[TcpEndpoint]:
    end = TcpEndpoint("127.0.0.1:0", OPTION)
    yield end
    end.close()


@pytest.fixture
def terminal() -> Iterator[PtyEndpoint]:
    end = PtyEndpoint(np.random.default_rng(0))
    yield end
    end.close()


def dial(end: TcpEndpoint) -> socket.socket:
    host, port = split_host_and_port(end.address.removeprefix("tcp:"), OPTION)
    return socket.create_connection((host, port), timeout=allowed(10.0))


def test_a_second_client_is_turned_away_and_the_first_one_stays(tcp: TcpEndpoint) -> None:
    with dial(tcp) as first:
        first.sendall(b"1")
        eventually(lambda: tcp.read(BAUD))
        with dial(tcp) as second:
            tcp.read(BAUD)
            assert second.recv(1) == b""
        first.sendall(b"2")
        assert eventually(lambda: tcp.read(BAUD)) == b"2"


def test_a_client_that_does_not_read_does_not_stop_the_robot(tcp: TcpEndpoint) -> None:
    with dial(tcp) as client:
        client.sendall(b"x")
        eventually(lambda: tcp.read(BAUD))
        for _ in range(2000):
            tcp.write(bytes(10_000), 0.0, BAUD)


def test_a_port_in_use_is_reported_in_one_line(tcp: TcpEndpoint) -> None:
    address = tcp.address.removeprefix("tcp:")
    with pytest.raises(DeviceError, match=f"{address} is in use: .*another --listen"):
        TcpEndpoint(address, OPTION)


@pytest.mark.parametrize("address", ["8101", "localhost", ":8101", "host:port", "h:70000", "h:"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="give HOST:PORT"):
        TcpEndpoint(address, OPTION)


def test_bytes_go_both_ways_over_a_pseudo_terminal_with_pyserial(terminal: PtyEndpoint) -> None:
    with serial.Serial(terminal.address, BAUD, timeout=allowed(5.0)) as client:
        client.write(bytes(range(256)))
        came = b""
        while len(came) < 256:
            came += eventually(lambda: terminal.read(BAUD))  # type: ignore[operator]
        assert came == bytes(range(256))
        said = bytes(reversed(range(256)))
        terminal.write(said, 0.0, BAUD)
        for tick in range(300):
            terminal.write(b"", 0.001 * tick, BAUD)
        assert client.read(256) == said


@pytest.mark.parametrize("ticks", [60])
def test_it_sends_no_faster_than_its_speed(terminal: PtyEndpoint, ticks: int) -> None:
    with serial.Serial(terminal.address, BAUD, timeout=0.2) as client:
        terminal.write(b"", 0.0, BAUD)
        for tick in range(ticks + 1):
            terminal.write(bytes(500) if tick == 0 else b"", 0.005 * tick, BAUD)
        came = b""
        while piece := client.read(1000):
            came += piece
    # 960 bytes a second
    assert len(came) == pytest.approx(4.8 * ticks, abs=2)


@pytest.mark.parametrize("speed", [38400])
def test_at_another_speed_both_sides_read_other_bytes(terminal: PtyEndpoint, speed: int) -> None:
    with serial.Serial(terminal.address, speed, timeout=allowed(5.0)) as client:
        terminal.read(BAUD)
        time.sleep(2 * UNDER_WAY)
        client.write(b"SYNC" * 10)
        came = eventually(lambda: terminal.read(BAUD))
        assert came != b"SYNC" * 10
        terminal.write(b"", 0.0, BAUD)
        terminal.write(b"ECHO" * 10, 0.0, BAUD)
        terminal.write(b"", 1.0, BAUD)
        heard = client.read(40)
        assert len(heard) == 40
        assert heard != b"ECHO" * 10
        client.baudrate = BAUD
        terminal.read(BAUD)
        client.write(b"SYNC")
        assert eventually(lambda: terminal.read(BAUD)) == b"SYNC"


def test_what_was_sent_before_a_change_of_speed_still_arrives(terminal: PtyEndpoint) -> None:
    with serial.Serial(terminal.address, BAUD, timeout=allowed(5.0)) as client:
        terminal.read(BAUD)
        client.write(b"HOSTBAUD")
        client.flush()
        client.baudrate = 38400
        assert eventually(lambda: terminal.read(BAUD)) == b"HOSTBAUD"


def test_a_terminal_that_nobody_reads_does_not_stop_the_robot(terminal: PtyEndpoint) -> None:
    for tick in range(3000):
        terminal.write(bytes(50), 0.05 * tick, BAUD)
