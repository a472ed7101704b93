"""Bytes to the robot and back, over a serial line or TCP; nothing else here opens a port.

The address decides which, without a fallback: a driver that tries a simulator's TCP port first, as
one in wide use does, drives the wrong robot.
"""

import contextlib
import errno
import re
import select
import socket
import termios
import time
from typing import Protocol

from facetlog.errors import DeviceError, DeviceTimeout, InputError, make_missing_extra_error

try:
    import serial
except ModuleNotFoundError as exc:
    raise make_missing_extra_error("a robot", "pyserial", "robot") from exc


DEFAULT_BAUD = 9600
"""Of the robot's host port when it is switched on (Pioneer 2 manual)."""
DEFAULT_TCP_PORT = 8101
"""Of simulators and serial servers, by convention of all drivers known."""
OPEN_TIMEOUT = 5.0
"""Seconds for a TCP connection: enough for two retransmissions of a lost first packet."""
WRITE_TIMEOUT = 1.0
"""Time-out of a write, seconds: a packet of 200 bytes takes 0.21 at 9600 baud."""
DRAIN_TIMEOUT = 0.5
CHUNK = 4096
ONE_CLIENT, WENT_OFF = "it may serve only one client", "what serves the robot there may have ended"
"""Why a connection may have been closed: before a byte came over it, and after."""


class Port(Protocol):
    """A line to the robot, or to a device of its own."""

    @property
    def address(self) -> str:
        """The address it was opened with, for messages."""

    @property
    def has_baud(self) -> bool:
        """Whether the line has a speed that both sides must agree on."""

    def read(self, timeout: float) -> bytes:
        """Return the bytes that came, at least one; b"" after so many seconds without any.

        DeviceError if the line is gone.
        """

    def write(self, data: bytes) -> None:
        """Send all of it; DeviceTimeout if the line does not take it, DeviceError if gone."""

    def set_baud(self, baud: int) -> None:
        """Change the line's speed once all is sent; nothing where a line has none."""

    def close(self) -> None:
        """Give the line back; more than once does no harm."""


class SerialPort:
    """A serial line, 8 bits, no parity, one stop bit; locked against other programs."""

    has_baud = True

    def __init__(self, path: str, baud: int = DEFAULT_BAUD) -> None:
        self.address = path
        try:
            self._serial = serial.Serial(
                path, baud, timeout=0, write_timeout=WRITE_TIMEOUT, exclusive=True
            )
        except (OSError, ValueError, termios.error) as error:
            raise DeviceError(f"{path}: {_explain_open_error(error)}") from error

    def fileno(self) -> int:
        """Return the descriptor to wait for."""
        return int(self._serial.fileno())

    def read(self, timeout: float) -> bytes:
        try:
            if not _wait_readable(self._serial.fileno(), timeout):
                return b""
            return bytes(self._serial.read(CHUNK))
        except (OSError, TypeError, ValueError) as error:  # TypeError: closed while it read
            raise DeviceError(f"{self.address}: the serial line is gone ({error})") from error

    def write(self, data: bytes) -> None:
        try:
            self._serial.write(data)
        except serial.SerialTimeoutException as error:
            raise DeviceTimeout(
                f"{self.address}: the serial line takes no bytes; check the cable's flow control"
            ) from error
        except (OSError, TypeError, ValueError) as error:
            raise DeviceError(f"{self.address}: the serial line is gone ({error})") from error

    def set_baud(self, baud: int) -> None:
        try:
            self._drain()
            self._serial.baudrate = baud
        except (OSError, ValueError, termios.error) as error:
            raise DeviceError(f"{self.address}: does not do {baud} baud ({error})") from error

    def close(self) -> None:
        """See `Port`; written bytes are still sent, for a bounded time."""
        if self._serial.is_open:
            with contextlib.suppress(OSError):
                self._drain()
            self._serial.close()

    def _drain(self) -> None:
        # Not tcdrain, which waits for ever where flow control blocks.
        deadline = time.monotonic() + DRAIN_TIMEOUT
        while self._serial.out_waiting and time.monotonic() < deadline:
            time.sleep(0.002)
        # The last byte leaves the driver's queue before it leaves the wire: two bytes of 10 bits.
        time.sleep(20 / self._serial.baudrate)


class TcpPort:
    """A TCP connection to a simulator or a serial server."""

    has_baud = False

    def __init__(self, host: str, port: int, timeout: float = OPEN_TIMEOUT) -> None:
        self.address = f"tcp:{host}:{port}"
        self._served = False
        try:
            self._socket = socket.create_connection((host, port), timeout=timeout)
        except TimeoutError as error:
            raise DeviceTimeout(
                f"{self.address}: no answer; check name, network and port"
            ) from error
        except OSError as error:
            reason = error.strerror or str(error)
            raise DeviceError(
                f"{self.address}: cannot connect ({reason}); is the robot's server or the simulator"
                " running there?"
            ) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(WRITE_TIMEOUT)

    def fileno(self) -> int:
        """Return the descriptor to wait for."""
        return self._socket.fileno()

    def read(self, timeout: float) -> bytes:
        try:
            if not _wait_readable(self._socket.fileno(), timeout):
                return b""
            data = self._socket.recv(CHUNK)
        except (OSError, ValueError) as error:
            raise DeviceError(f"{self.address}: the connection broke ({error})") from error
        if not data:
            # Who is busy with another client never says a word to this one.
            why = WENT_OFF if self._served else ONE_CLIENT
            raise DeviceError(f"{self.address}: the other side closed the connection; {why}")
        self._served = True
        return data

    def write(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except TimeoutError as error:
            raise DeviceTimeout(f"{self.address}: the other side takes no bytes") from error
        except OSError as error:
            raise DeviceError(f"{self.address}: the connection broke ({error})") from error

    def set_baud(self, baud: int) -> None:
        """Do nothing: a connection has no speed."""

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


def open_port(
    address: str, baud: int | None = None, timeout: float = OPEN_TIMEOUT
) -> SerialPort | TcpPort:
    """Return the port of an address, open: `tcp:HOST:PORT`, `HOST:PORT`, `serial:PATH` or a path.

    A TCP connection may take `timeout` seconds. InputError if it is none of these, or if `baud` is
    given for TCP; DeviceError or DeviceTimeout if it cannot be opened. Nothing else is tried then.
    """
    if address.startswith("serial:"):
        return SerialPort(address.removeprefix("serial:"), baud or DEFAULT_BAUD)
    if (place := _parse_tcp_address(address)) is not None:
        if baud is not None:
            raise InputError(f"{address}: a TCP connection has no baud rate; leave it out")
        return TcpPort(*place, timeout)
    if "/" in address:
        return SerialPort(address, baud or DEFAULT_BAUD)
    raise InputError(
        f"{address!r} is no address of a robot: give tcp:HOST:PORT, HOST:PORT, serial:PATH or a"
        " path such as /dev/ttyUSB0"
    )


def _parse_tcp_address(address: str) -> tuple[str, int] | None:
    named = address.startswith("tcp:")
    match = re.fullmatch(
        r"(?P<host>\[[^\]]+\]|[^:/\s]+)(?::(?P<port>\d{1,5}))?", address.removeprefix("tcp:")
    )
    if match is None or (match["port"] is None and not named):
        if named:
            raise InputError(f"{address!r} is no TCP address: write tcp:HOST:PORT")
        return None
    port = DEFAULT_TCP_PORT if match["port"] is None else int(match["port"])
    if not 0 < port < 65536:
        raise InputError(f"{address!r}: {port} is no TCP port (1 … 65535)")
    return match["host"].strip("[]"), port


def _wait_readable(descriptor: int, timeout: float) -> bool:
    # Not select(), which refuses descriptors from 1024 on.
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(max(0.0, timeout) * 1000))


def _explain_open_error(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number in (errno.EAGAIN, errno.EBUSY):
        return "another program has this port; close it first"
    if number in (errno.EACCES, errno.EPERM):
        return "you may not open this port; join the group that owns it (often dialout)"
    if number == errno.ENOENT:
        return "there is no such port; check the name and that the adapter is plugged in"
    if isinstance(error, ValueError):
        return f"cannot be opened ({error})"
    return f"is not a serial line that can be used ({error})"
