import socket
import threading

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


def test_bytes_and_the_end_go_to_the_port() -> None:
    port = ScriptedPort()
    line = PortLine(port)
    line.send(b"\x81\x09\x06\x12\xff")
    line.close()
    assert port.written == b"\x81\x09\x06\x12\xff"
    assert port.closed


def test_waiting_ends_when_the_bytes_come_over_a_real_socket() -> None:
    ours, theirs = socket.socketpair()

    class SocketPort:
        def read(self, timeout: float) -> bytes:
            ours.settimeout(max(timeout, 0.001))
            try:
                return ours.recv(100)
            except TimeoutError:
                return b""

        def write(self, data: bytes, /) -> None:
            ours.sendall(data)

        def close(self) -> None:
            ours.close()

    with theirs:
        line = PortLine(SocketPort())
        answering = threading.Timer(0.1, theirs.sendall, [b"\x90\x41\xff"])
        answering.start()
        assert line.receive(3, 30.0) == b"\x90\x41\xff"
        answering.join()
        line.close()
