"""Where clients reach the simulated robot and its head: a TCP port, or a pseudo terminal."""

import logging
import os
import pty
import select
import socket
import termios
import tty
from contextlib import suppress
from typing import Protocol

import numpy as np

from facetlog.robot.simulator.address import listener

__all__ = ["Endpoint", "PtyEndpoint", "TcpEndpoint"]

CHUNK = 4096
BITS_A_BYTE = 10  # with start and stop bit
UNSENT = 1024
"""Bytes that wait for the line at most; as on a real one, what comes on top is lost."""
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
        """What a client gives to reach it."""

    def descriptors(self) -> list[int]:
        """What to wait for."""

    def read(self, baud: int) -> bytes:
        """What came from a client since it was asked last."""

    def write(self, data: bytes, now: float, baud: int) -> None:
        """Sends to the client, if there is one."""

    def close(self) -> None:
        """Gives everything back."""


class TcpEndpoint:
    """A TCP port with one client at a time; another one is turned away at once.

    Like a serial line it tells the robot nothing of clients that come and go.
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
        """Of the port, and of the client's connection."""
        sockets = (self._listener, self._client)
        return [each.fileno() for each in sockets if each is not None]

    def read(self, baud: int) -> bytes:  # noqa: ARG002 - a TCP line has no speed
        """What the client sent; takes another client if there is none."""
        data = self._received()
        self._accept()
        return data

    def write(self, data: bytes, now: float, baud: int) -> None:  # noqa: ARG002
        """What the connection does not take at once is lost, as on a line without handshake."""
        if self._client is None or not data:
            return
        try:
            self._client.send(data)
        except BlockingIOError:
            return
        except OSError:
            self._hang_up()

    def close(self) -> None:
        """Closes port and connection."""
        self._hang_up()
        self._listener.close()

    def _received(self) -> bytes:
        if self._client is None:
            return b""
        try:
            data = self._client.recv(CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def _accept(self) -> None:
        with suppress(BlockingIOError):
            while True:
                client, _ = self._listener.accept()
                if self._client is not None:
                    client.close()
                    _LOG.warning("%s: a second client was turned away", self.address)
                    continue
                client.setblocking(False)
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._client = client

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


class PtyEndpoint:
    """A pseudo terminal: a serial port to whoever opens it, at whatever speed they set.

    What is sent at another speed than that of the other side arrives as other bytes.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)  # or the robot's own reports would come back as an echo
        os.set_blocking(self._master, False)
        self._unsent = bytearray()
        self._sent_until = 0.0

    @property
    def address(self) -> str:
        """Path of the device that clients open."""
        return os.ttyname(self._slave)

    def descriptors(self) -> list[int]:
        """Of the side that is not the clients'."""
        return [self._master]

    def read(self, baud: int) -> bytes:
        """What clients sent."""
        try:
            data = os.read(self._master, CHUNK)
        except OSError:  # nothing there
            return b""
        return data if self._speed() == baud else self._rng.bytes(len(data))

    def write(self, data: bytes, now: float, baud: int) -> None:
        """Sends as fast as the speed lets it; the rest the next time."""
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

    def close(self) -> None:
        """Gives the pseudo terminal back."""
        os.close(self._master)
        os.close(self._slave)

    def _speed(self) -> int | None:
        """What the client has set; as much as both of its directions agree."""
        _, _, _, _, ispeed, ospeed, _ = termios.tcgetattr(self._slave)
        return BAUDS.get(ospeed) if ispeed == ospeed else None
