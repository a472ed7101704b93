"""Where clients reach the simulated robot and its head: a TCP port, or a pseudo terminal."""

import errno
import logging
import math
import os
import pty
import select
import socket
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import suppress
from typing import Protocol

import numpy as np

from facetlog.errors import DeviceError, InputError


def split_host_and_port(address: str, option: str) -> tuple[str, int]:
    """Return host and port of `HOST:PORT` (port 0: any free one); InputError names the `option`.

    >>> split_host_and_port("127.0.0.1:8101", "--listen")
    ('127.0.0.1', 8101)
    """
    host, colon, port = address.rpartition(":")
    if not (host and colon and port.isascii() and port.isdigit() and int(port) <= 0xFFFF):
        raise InputError(f"{option} {address}: give HOST:PORT, as 127.0.0.1:8101")
    return host.strip("[]"), int(port)


def bound(error: OSError, address: str, option: str) -> DeviceError:
    """Return the error of an address at which nothing can listen."""
    if error.errno == errno.EADDRINUSE:
        return DeviceError(f"{address} is in use: end what listens there, or give another {option}")
    reason = os.strerror(error.errno) if error.errno else str(error)
    return DeviceError(f"{address}: nothing can listen there ({reason}): give another {option}")


def listener(address: str, option: str) -> socket.socket:
    """Open a socket that listens there without blocking; DeviceError if it cannot."""
    host, port = split_host_and_port(address, option)
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        made = socket.create_server((host, port), family=family, backlog=2)
    except OSError as error:
        raise bound(error, address, option) from error
    made.setblocking(False)
    return made


CHUNK = 4096
AT_ONCE = 16 * CHUNK  # more than a line carries in a second: a flood must not hold up the robot
BITS_A_BYTE = 10  # with start and stop bit
UNSENT = 1024
"""Bytes that wait for the line at most; as on a real one, what comes on top is lost."""
UNDER_WAY = 0.05
"""Seconds that bytes may take through the pseudo terminal, on a machine that has other work."""
OUTPUT_SPEED = 5  # its place in what tcgetattr gives
BAUDS = {
    termios.B9600: 9600,
    termios.B19200: 19200,
    termios.B38400: 38400,
    termios.B57600: 57600,
    termios.B115200: 115200,
}

_LOG = logging.getLogger(__name__)


class Endpoint(Protocol):
    """One end of a line; nothing here blocks. `baud` is the speed of the simulated side."""

    @property
    def address(self) -> str:
        """The address by which a client reaches it."""

    def descriptors(self) -> list[int]:
        """Return the descriptors to wait for."""

    def read(self, baud: int) -> bytes:
        """Return bytes from a client since the last call."""

    def write(self, data: bytes, now: float, baud: int) -> None:
        """Send to the client, if there is one."""

    def hang_up(self) -> None:
        """Close the client's connection, where there is one to close; another is taken."""

    def close(self) -> None:
        """Give everything back."""


class TcpEndpoint:
    """A TCP port with one client at a time; another one is turned away at once.

    As on a serial line the robot does not notice clients that come and go.
    """

    def __init__(self, address: str, option: str) -> None:
        self._listener = listener(address, option)
        self._client: socket.socket | None = None

    @property
    def address(self) -> str:
        """As `tcp:HOST:PORT`."""
        host, port = self._listener.getsockname()[:2]
        return f"tcp:{host}:{port}"

    def descriptors(self) -> list[int]:
        """Return the descriptors of the port and of the client's connection."""
        sockets = (self._listener, self._client)
        return [each.fileno() for each in sockets if each is not None]

    def read(self, baud: int) -> bytes:  # noqa: ARG002 - a TCP line has no speed
        """Return the bytes of the client, and take another client if there is none."""
        data = self._received()
        for client in self._iter_callers():
            data += self._received()  # the one before may just have gone
            if self._client is None:
                self._client = client
            else:
                client.close()
                _LOG.warning("%s: a second client was turned away", self.address)
        return data

    def write(self, data: bytes, now: float, baud: int) -> None:  # noqa: ARG002
        """Send bytes; those that the connection does not take at once are lost."""
        if self._client is None or not data:
            return
        try:
            self._client.send(data)
        except BlockingIOError:
            return
        except OSError:
            self.hang_up()

    def hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def close(self) -> None:
        self.hang_up()
        self._listener.close()

    def _received(self) -> bytes:
        """Return the bytes that came, up to a limit, and hang up if the client has."""
        data = b""
        while self._client is not None and len(data) < AT_ONCE:
            try:
                piece = self._client.recv(CHUNK)
            except BlockingIOError:
                break
            except OSError:
                piece = b""
            data += piece
            if not piece:
                self.hang_up()
        return data

    def _iter_callers(self) -> Iterator[socket.socket]:
        with suppress(BlockingIOError):
            while True:
                client, _ = self._listener.accept()
                client.setblocking(False)
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                yield client


class PtyEndpoint:
    """A pseudo terminal: a serial port to whoever opens it, at whatever speed they set.

    What is sent at another speed than that of the other side arrives as other bytes.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)  # or the robot's own reports would come back as an echo
        os.set_blocking(self._master, False)
        self._now = self._before = self._speed()
        self._changed = -math.inf
        self._unsent = bytearray()
        self._sent_until = 0.0

    @property
    def address(self) -> str:
        """Path of the device that clients open."""
        return os.ttyname(self._slave)

    def descriptors(self) -> list[int]:
        """Return the descriptor of the side that is not the clients'."""
        return [self._master]

    def read(self, baud: int) -> bytes:
        speed, at = self._speed(), time.monotonic()
        if speed != self._now:
            self._before, self._now, self._changed = self._now, speed, at
        try:
            data = os.read(self._master, CHUNK)
        except OSError:  # nothing there
            return b""
        # A client may have sent this just before it changed its speed.
        recent = self._before if at - self._changed < UNDER_WAY else speed
        return data if baud in (speed, recent) else self._rng.bytes(len(data))

    def write(self, data: bytes, now: float, baud: int) -> None:
        """Send as fast as the speed lets it; the rest the next time."""
        self._unsent += data[: UNSENT - len(self._unsent)]
        self._sent_until = max(self._sent_until, now - CHUNK * BITS_A_BYTE / baud)
        count = min(int((now - self._sent_until) * baud / BITS_A_BYTE), len(self._unsent))
        if not self._unsent:
            self._sent_until = now
        if count <= 0:
            return
        self._sent_until += count * BITS_A_BYTE / baud
        piece = bytes(self._unsent[:count])
        del self._unsent[:count]
        if not select.select([], [self._master], [], 0)[1]:
            return  # nobody reads: lost, as on a real line
        with suppress(BlockingIOError):
            os.write(self._master, piece if self._speed() == baud else self._rng.bytes(count))

    def hang_up(self) -> None:
        """Do nothing: a serial line has no connection."""

    def close(self) -> None:
        """Give the pseudo terminal back."""
        os.close(self._master)
        os.close(self._slave)

    def _speed(self) -> int | None:
        """Return the baud rate that the client has set."""
        return BAUDS.get(termios.tcgetattr(self._slave)[OUTPUT_SPEED])
