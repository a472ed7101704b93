"""The process that owns the line to a robot: it passes bytes on, and stops the robot by itself.

The program that drives may hang in a computation, be suspended, be killed, or starve on a busy
machine. This process does nothing but wait for the line and for that program, which holds a lease
(`dead_man.py`): when it runs out, when the program is gone, or when the line itself breaks, the
robot is stopped from here, over the line opened again if need be. It knows nothing of the robot's
protocol: what stops the robot, and what closes its session, come from the driver, as bytes.

Messages between the two processes are packets of a socket whose first byte is their kind (`Ask`,
`Say`). Started by `process.py` with the socket's number and the line's address.
"""

import contextlib
import os
import select
import signal
import socket
import struct
import sys
import time
from enum import IntEnum
from functools import partial

from facetlog.errors import DeviceError, DeviceTimeout, FacetlogError, InputError
from facetlog.robot.pioneer.line.dead_man import DeadMan, LastWill, NotStoppedError
from facetlog.robot.pioneer.line.port import SerialPort, TcpPort, open_port

LARGEST = 8192
"""Bytes of a message at most: twice what is read from a line at once."""
LEASE_END, RATE = struct.Struct("<d"), struct.Struct("<I")
LOOK_EVERY = 0.1
"""Seconds: how late it is noticed that the program is gone where a fork of it still has its end of
the socket."""


class Ask(IntEnum):
    """Kinds of messages from the driver."""

    WRITE = 0
    """Bytes for the line."""
    HOLD = 1
    """The time at which the lease ends, then the bytes that stop the robot."""
    RELEASE = 2
    SET_BAUD = 3
    PART = 4
    """A command for the end of a session whose driver is gone; in the order in which they come."""
    CLOSE = 5


class Say(IntEnum):
    """Kinds of messages to the driver."""

    READ = 0
    """Bytes from the line."""
    DONE = 1
    """The rate is set, or the line open: a byte says whether it has a rate, then its address."""
    DEVICE_ERROR = 2
    DEVICE_TIMEOUT = 3
    INPUT_ERROR = 4
    NOT_STOPPED = 5


ERRORS: dict[Say, type[FacetlogError]] = {
    Say.NOT_STOPPED: NotStoppedError,
    Say.DEVICE_TIMEOUT: DeviceTimeout,
    Say.DEVICE_ERROR: DeviceError,
    Say.INPUT_ERROR: InputError,
}


class _LineOwner:
    """The line, the lease, and the socket to the driver."""

    def __init__(self, driver: socket.socket, address: str, baud: int | None) -> None:
        self._driver, self._address, self._baud = driver, address, baud
        self._parent = os.getppid()
        self._dead_man = DeadMan()
        self._parting: list[bytes] = []
        self._closed = False
        self._port: SerialPort | TcpPort | None = None

    def run(self) -> None:
        """Open the line and serve it until the driver closes it, or is gone and it is stopped."""
        try:
            port = self._port = open_port(self._address, self._baud)
        except FacetlogError as error:
            self._fail(error)
            return
        self._say(Say.DONE, bytes([port.has_baud]) + port.address.encode())
        broken: DeviceError | None = None
        try:
            self._serve(port)
        except DeviceError as error:
            self._port = None
            port.close()
            broken = error
            if not self._dead_man.holds:
                self._closed = True  # nothing is left to be done on it
                self._fail(error)
        if not self._closed:
            will = LastWill(self._address, self._baud, self._port)
            will.stop_and_close(self._dead_man, self._parting, partial(self._stopped, broken))
            self._port = will.port
        if self._port is not None:
            self._port.close()

    def _stopped(self, broken: DeviceError | None, took: bool) -> None:
        """Say of a line that broke whether the robot was stopped over it, opened again."""
        if broken is None:
            return
        if took:
            self._fail(type(broken)(f"{broken}; it was opened again to stop the robot"))
        else:
            self._fail(
                NotStoppedError(f"{broken}; it cannot be opened again: the robot was not stopped")
            )

    def _serve(self, port: SerialPort | TcpPort) -> None:
        """Serve until the driver closes the line or is gone; DeviceError if the line breaks."""
        poll = select.poll()
        poll.register(self._driver, select.POLLIN)
        poll.register(port.fileno(), select.POLLIN)
        while os.getppid() == self._parent:
            wait = min(self._dead_man.due - time.monotonic(), LOOK_EVERY)
            ready = {descriptor for descriptor, _ in poll.poll(max(0.0, wait) * 1e3)}
            # What the driver has said comes before what is done if it says nothing.
            if self._driver.fileno() in ready and not self._heard(port):
                return
            if stop := self._dead_man.advance(time.monotonic()):
                port.write(stop)
            if port.fileno() in ready and (data := port.read(0.0)):
                self._say(Say.READ, data)
        self._heard(port)  # the last that it has said

    def _heard(self, port: SerialPort | TcpPort) -> bool:
        """Do all that the driver asks for; False if it has closed the line or is gone."""
        while True:
            try:
                message = self._driver.recv(LARGEST, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return True
            except OSError:
                return False
            if not message:
                return False
            kind, content = Ask(message[0]), message[1:]
            now = time.monotonic()
            match kind:
                case Ask.WRITE:
                    if not self._dead_man.has_expired(now):
                        port.write(content)
                case Ask.HOLD:
                    (until,) = LEASE_END.unpack_from(content)
                    self._dead_man.hold(until, content[LEASE_END.size :], now)
                case Ask.RELEASE:
                    self._dead_man.release()
                case Ask.SET_BAUD:
                    (self._baud,) = RATE.unpack(content)
                    port.set_baud(self._baud)
                    self._say(Say.DONE)
                case Ask.PART:
                    self._parting.append(content)
                case Ask.CLOSE:
                    # Where the lease has run out, what the driver sent to part was dropped.
                    self._closed = not self._dead_man.has_expired(now)
                    return False

    def _say(self, kind: Say, content: bytes = b"") -> None:
        """Report the driver; what a suspended one has no room for is lost: it would be old."""
        with contextlib.suppress(OSError):
            self._driver.send(bytes([kind]) + content, socket.MSG_DONTWAIT)

    def _fail(self, error: FacetlogError) -> None:
        kind = next(kind for kind, each in ERRORS.items() if isinstance(error, each))
        self._say(kind, str(error).encode())


def main(descriptor: int, address: str, baud: int | None) -> None:
    """Serve one line."""
    # What ends the program ends this process, after the robot was stopped: never before.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP):
        signal.signal(number, signal.SIG_IGN)
    with socket.socket(fileno=descriptor) as driver:
        _LineOwner(driver, address, baud).run()


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else None)
