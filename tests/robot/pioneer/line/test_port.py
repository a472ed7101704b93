"""Ports: addresses, real sockets, a real pseudo-terminal with pyserial on it."""

import os
import pty
import socket
import time
import tty
from collections.abc import Iterator

import pytest

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.pioneer.line import port as ports
from facetlog.robot.pioneer.line.port import Port, SerialPort, open_port


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(10)
        yield listening


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    """The other side of a serial line, and the line's path."""
    other, line = pty.openpty()
    tty.setraw(line)
    yield other, os.ttyname(line)
    os.close(line)
    os.close(other)


def read_exactly(port: Port, count: int) -> bytes:
    data, deadline = b"", time.monotonic() + 10
    while len(data) < count and time.monotonic() < deadline:
        data += port.read(0.2)
    return data


@pytest.mark.parametrize("form", ["tcp:{}:{}", "{}:{}"])
def test_bytes_go_both_ways_over_tcp(server: socket.socket, form: str) -> None:
    port = open_port(form.format(*server.getsockname()))
    accepted, _ = server.accept()
    with accepted:
        port.write(b"\xfa\xfb\x03")
        assert accepted.recv(10) == b"\xfa\xfb\x03"
        accepted.sendall(bytes(range(256)))
        assert read_exactly(port, 256) == bytes(range(256))
        assert port.has_baud is False
        port.set_baud(38400)
        port.close()
        assert accepted.recv(1) == b""
    port.close()


def test_a_server_that_takes_no_bytes_is_a_time_out(
    server: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ports, "WRITE_TIMEOUT", 0.1)
    port = open_port("tcp:{}:{}".format(*server.getsockname()))
    try:
        with pytest.raises(DeviceTimeout, match="takes no bytes"):
            port.write(bytes(50_000_000))
    finally:
        port.close()


def test_nobody_listening_is_an_error_and_nothing_else_is_tried() -> None:
    with socket.create_server(("127.0.0.1", 0)) as unused:
        address = "tcp:{}:{}".format(*unused.getsockname())
    with pytest.raises(DeviceError, match="running there"):
        open_port(address)


@pytest.mark.parametrize("form", ["serial:{}", "{}"])
def test_bytes_go_both_ways_over_a_serial_line(terminal: tuple[int, str], form: str) -> None:
    other, path = terminal
    port = open_port(form.format(path))
    try:
        port.write(b"\xfa\xfb\x00\x11\x13\xff")
        assert os.read(other, 10) == b"\xfa\xfb\x00\x11\x13\xff"
        os.write(other, b"\x00\x03\x0a\x0d\x11\xff")
        assert read_exactly(port, 6) == b"\x00\x03\x0a\x0d\x11\xff"
        assert port.has_baud is True
        port.set_baud(38400)
        assert port.read(0.01) == b""
    finally:
        port.close()
    port.close()


def test_an_adapter_that_is_pulled_out_is_said() -> None:
    other, line = pty.openpty()
    port = SerialPort(os.ttyname(line))
    os.close(line)
    os.close(other)
    with pytest.raises(DeviceError, match="serial line is gone"):
        port.read(10.0)
    with pytest.raises(DeviceError, match="serial line is gone"):
        port.write(b"\xfa")
    port.close()


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("", "no address"),
        ("ttyUSB0", "no address"),
        ("tcp:", "no TCP address"),
        ("tcp:host:port", "no TCP address"),
        ("host:99999", "no TCP port"),
        ("host:0", "no TCP port"),
    ],
)
def test_what_is_no_address_is_the_users_matter(address: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        open_port(address)


def test_a_baud_rate_for_tcp_is_refused() -> None:
    with pytest.raises(InputError, match="no baud rate"):
        open_port("tcp:127.0.0.1:8101", 9600)


def test_the_default_port_is_the_one_of_simulators(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, int]] = []
    monkeypatch.setattr(ports, "TcpPort", lambda host, number, _: asked.append((host, number)))
    open_port("tcp:robot")
    open_port("tcp:[::1]:8102")
    assert asked == [("robot", 8101), ("::1", 8102)]
