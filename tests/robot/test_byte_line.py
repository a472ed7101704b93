import pytest

from facetlog.errors import DeviceTimeout
from facetlog.robot.byte_line import PortLine


class ScriptedPort:
    """Gives out the chunks it was made with, then nothing."""

    def __init__(self, *chunks: bytes) -> None:
        self.chunks, self.written, self.closed = list(chunks), b"", False

    def read(self, _timeout: float, /) -> bytes:
        return self.chunks.pop(0) if self.chunks else b""

    def write(self, data: bytes, /) -> None:
        self.written += data

    def close(self) -> None:
        self.closed = True


class ChatteringPort(ScriptedPort):
    def read(self, _timeout: float, /) -> bytes:
        return b"x"


def test_a_count_of_bytes_is_put_together_of_whatever_chunks_come() -> None:
    line = PortLine(ScriptedPort(b"\x90", b"\x41\xff\x90", b"\x51\xff"))
    assert line.receive(3, 1.0) == b"\x90\x41\xff"
    assert line.receive(3, 1.0) == b"\x90\x51\xff"


def test_too_few_bytes_are_a_time_out_and_stay_for_the_next_call() -> None:
    port = ScriptedPort(b"\x90\x41")
    line = PortLine(port)
    with pytest.raises(DeviceTimeout, match="2 of 3 bytes"):
        line.receive(3, 0.05)
    port.chunks = [b"\xff"]
    assert line.receive(3, 1.0) == b"\x90\x41\xff"


def test_a_flush_forgets_what_is_there_and_what_was_kept() -> None:
    port = ScriptedPort(b"abcdef")
    line = PortLine(port)
    assert line.receive(2, 1.0) == b"ab"
    port.chunks = [b"old"]
    line.flush()
    port.chunks = [b"new"]
    assert line.receive(3, 1.0) == b"new"


def test_a_flush_of_a_device_that_never_stops_talking_ends() -> None:
    line = PortLine(ChatteringPort())
    line.flush()
    assert line.receive(3, 1.0) == b"xxx"
