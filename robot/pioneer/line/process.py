"""A port whose line is owned by a process of its own (`owner.py`), which outlives this one.

The robot is then stopped within its lease whatever becomes of this process: killed, suspended, out
of memory, or computing without a pause. Where the other one is killed, this one stops the robot.
"""

import contextlib
import select
import socket
import subprocess
import time
from collections import deque
from collections.abc import Sequence

from facetlog.errors import DeviceError, DeviceTimeout, FacetlogError
from facetlog.python_process import make_importing_environment, make_module_command
from facetlog.robot.pioneer.line.dead_man import STOPPING, DeadMan, LastWill, NotStoppedError
from facetlog.robot.pioneer.line.owner import ERRORS, LARGEST, LEASE_END, RATE, Ask, Say

OWNER = "facetlog.robot.pioneer.line.owner"
START_TIMEOUT = 30.0
"""Seconds for Python to start and the line to be opened: 0.1 are usual, 5 a TCP line's time-out."""
BAUD_TIMEOUT = 2.0
"""Seconds for what was written to be sent, and the rate to be set: half of one is allowed for."""
CLOSE_TIMEOUT = STOPPING + 2.0
"""Seconds for the line to be given back: a robot whose line broke is stopped first."""


class LineProcess:
    """See `Port`; besides, `hold` and `release` set what the process does when this one is gone.

    InputError, DeviceError or DeviceTimeout as of `open_port`.
    """

    def __init__(self, address: str, baud: int | None = None) -> None:
        self.address, self.has_baud = address, False
        self._fault: FacetlogError | None = None
        self._baud = baud
        # What the owner would do, were it still there.
        self._dead_man, self._parting = DeadMan(), list[bytes]()
        self._read: deque[bytes] = deque()
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            descriptor = theirs.fileno()
            rate = [] if baud is None else [str(baud)]
            self._process = subprocess.Popen(
                make_module_command(OWNER, str(descriptor), address, *rate),
                pass_fds=[descriptor],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                # Signals of the terminal are for this process, which stops the robot in order.
                start_new_session=True,
                env=make_importing_environment(),
            )
        try:
            has_baud, *said = self._done(START_TIMEOUT)
        except BaseException:
            self.close()
            raise
        self.has_baud, self.address = bool(has_baud), bytes(said).decode()

    @property
    def process(self) -> int:
        """The number of the process that owns the line."""
        return self._process.pid

    def read(self, timeout: float) -> bytes:
        if self._read:
            return self._read.popleft()
        kind, content = self._heard(timeout)
        return content if kind is Say.READ else b""

    def write(self, data: bytes) -> None:
        """See `Port`; a fault of the line is raised by `read` too."""
        self._ask(Ask.WRITE, data)

    def hold(self, until: float, stop: bytes) -> None:
        """Let the robot be driven until a time (monotonic); `stop` is written to it then.

        What is written after that time is dropped, until there is a later one.
        """
        self._dead_man.hold(until, stop, time.monotonic())
        self._ask(Ask.HOLD, LEASE_END.pack(until) + stop)

    def release(self) -> None:
        """Write nothing at the end: the robot does not move."""
        self._dead_man.release()
        self._ask(Ask.RELEASE)

    def part(self, commands: Sequence[bytes]) -> None:
        """Set what ends the robot's session if this process is gone, in the order of sending."""
        for command in commands:
            self._parting.append(command)
            self._ask(Ask.PART, command)

    def set_baud(self, baud: int) -> None:
        self._baud = baud if self.has_baud else None
        self._ask(Ask.SET_BAUD, RATE.pack(baud))
        self._done(BAUD_TIMEOUT)

    def close(self) -> None:
        self._dead_man.release()
        with contextlib.suppress(OSError):
            self._socket.send(bytes([Ask.CLOSE]), socket.MSG_DONTWAIT)
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        try:
            self._process.wait(CLOSE_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _ask(self, kind: Ask, content: bytes = b"") -> None:
        try:
            self._socket.send(bytes([kind]) + content, socket.MSG_DONTWAIT)
        except BlockingIOError as error:
            raise DeviceTimeout(
                f"{self.address}: the process that owns the line takes no bytes: is it suspended?"
            ) from error
        except OSError as error:
            raise self._fault or self._take_over_from_owner() from error

    def _done(self, timeout: float) -> bytes:
        """Wait for the report that something is done; keep the bytes read meanwhile."""
        deadline = time.monotonic() + timeout
        while (left := deadline - time.monotonic()) > 0:
            kind, content = self._heard(left)
            if kind is Say.DONE:
                return content
            if kind is Say.READ:
                self._read.append(content)
        raise DeviceTimeout(f"{self.address}: the process that owns the line does not answer")

    def _heard(self, timeout: float) -> tuple[Say | None, bytes]:
        """Return the next message, None if there is none in time; what went wrong is raised."""
        if self._fault is not None:
            raise type(self._fault)(*self._fault.args)
        try:
            poll = select.poll()
            poll.register(self._socket, select.POLLIN)
            if not poll.poll(max(0.0, timeout) * 1e3):
                return None, b""
            message = self._socket.recv(LARGEST)
        except (OSError, ValueError) as error:
            raise self._take_over_from_owner() from error
        if not message:
            self._fault = self._take_over_from_owner()
            raise self._fault
        kind, content = Say(message[0]), message[1:]
        if kind in ERRORS:
            self._fault = ERRORS[kind](content.decode())
            raise self._fault
        return kind, content

    def _take_over_from_owner(self) -> DeviceError:
        """Do for a robot that moves what the owner, which was killed, would have done.

        Its last lease counts as run out, as it does where this process is gone.
        """
        if self._fault is not None or not self._dead_man.holds:
            return DeviceError(f"{self._ended}; connect again")
        # Others that ask meanwhile are refused at once.
        self._fault = DeviceError(f"{self._ended}, and the robot is being stopped; connect again")
        will = LastWill(self.address, self._baud)
        took = will.stop_and_close(self._dead_man, self._parting)
        if will.port is not None:
            will.port.close()
        if took:
            self._fault = DeviceError(
                f"{self._ended}: the robot was stopped over the line opened again; connect again"
            )
        else:
            self._fault = NotStoppedError(
                f"{self._ended}, and its line cannot be opened again: the robot was not stopped"
            )
        return self._fault

    @property
    def _ended(self) -> str:
        return f"{self.address}: the process that owns the line has ended"
