"""The log of the traffic: every byte, in order, and never in the robot's way."""

import json
import threading
from pathlib import Path

import pytest

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.traffic import TrafficLog


def lines_of(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def test_lines_have_time_direction_bytes_and_name(tmp_path: Path) -> None:
    log = TrafficLog(tmp_path / "traffic.jsonl")
    log.start(0.5, "tcp:robot:8101", serial=False, model=None, baud=None)
    log.log_outgoing(1.0, make_integer_command(Command.VEL, 200).to_bytes())
    log.incoming(1.25, Packet(2, b"\0\0\0").to_bytes())
    log.close()
    start, out, in_ = lines_of(log.path)
    assert (start["at"], start["schema"], start["address"]) == (0.5, 1, "tcp:robot:8101")
    assert out == {"at": 1.0, "direction": "out", "hex": "fafb060b3bc800d33b", "name": "VEL 200"}
    assert (in_["direction"], in_["name"]) == ("in", "SYNC2")


def test_bytes_are_kept_as_they_came_and_named_where_a_packet_is_whole(tmp_path: Path) -> None:
    log = TrafficLog(tmp_path / "traffic.jsonl")
    wire = Packet(0xB0, b"\x90\x50").to_bytes()
    log.incoming(1.0, b"\x00" + wire[:3])
    log.incoming(2.0, wire[3:])
    log.incoming(3.0, wire[:4])
    log.incoming(4.0, b"")
    log.incoming(5.0, wire)
    log.close()
    assert [line["name"] for line in lines_of(log.path)] == ["", "SERAUX", "", "", "SERAUX"]
    assert lines_of(log.path)[0]["hex"] == "00" + wire[:3].hex()


def test_a_full_disk_is_said_once_and_nothing_else_happens() -> None:
    said: list[str] = []
    log = TrafficLog(Path("/dev/full"))
    for i in range(100):
        log.log_outgoing(float(i), make_plain_command(Command.PULSE).to_bytes())
    log.close()
    log.on_failure(said.append)  # later than it failed
    assert len(said) == 1
    assert "No space left" in said[0]
    assert log.broken == said[0]


def test_a_disk_that_does_not_keep_up_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("facetlog.robot.pioneer.traffic.WAITING_LINES", 10)
    said: list[str] = []
    log, go_on = TrafficLog(tmp_path / "traffic.jsonl"), threading.Event()
    log.on_failure(said.append)
    monkeypatch.setattr(log, "_write", lambda _: go_on.wait(20))
    for i in range(50):
        log.log_outgoing(float(i), b"\x00")
    assert said == [log.broken]
    assert "does not keep up" in said[0]
    go_on.set()
    log.close()
    assert not log._thread.is_alive()
