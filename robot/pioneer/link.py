"""The two threads between a port and the driver's control logic, and lines to the AUX ports.

The state of `Control` is guarded by one lock, whose condition waiters wait on. Everything is sent
under a second lock, which is taken before the first; so the sender knows what was sent. Where a
separate process owns the line, it gets the lease before speeds are sent, and is released only after
the robot is reported to stand.

The robot buffers the bytes of a device on an AUX port and sends n of them, once, when n are
requested and there. So an answer is read by requesting exactly its length (Pioneer 2 manual).
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.control import Control
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.line.port import Port
from facetlog.robot.pioneer.line.process import LineProcess
from facetlog.robot.pioneer.packets.commands import (
    LARGEST_TEXT,
    Command,
    make_integer_command,
    make_plain_command,
    make_text_command,
)
from facetlog.robot.pioneer.packets.packet import Packet, Received, Receiver
from facetlog.robot.pioneer.packets.reports import Report
from facetlog.robot.pioneer.traffic import TrafficLog

LOGGER = logging.getLogger(__name__)
READ_TIMEOUT = 0.05
"""Seconds: how late the reader notices that it must end."""
LOOK_EVERY = 0.05
"""Seconds: how late the writer notices that the thread which drives has ended."""
SLOW_SPACING, FAST_SPACING = 0.05, 0.005
"""Seconds between commands: P2OS takes one in each half cycle, AROS one in 3 to 5 ms (manuals)."""
JOIN_TIMEOUT = 3.0
"""Seconds: longer than a write may take."""
KEPT = 256


class Inbox:
    """A queue of received packets of one kind, the newest 256."""

    def __init__(self, link: "Link") -> None:
        self._link = link
        self._packets: deque[Received] = deque(maxlen=KEPT)

    def put(self, received: Received) -> None:
        """Take one; the link's lock is held."""
        self._packets.append(received)

    def clear(self) -> None:
        """Discard all that is queued."""
        with self._link.changed:
            self._packets.clear()

    def take(self, timeout: float) -> Packet | None:
        """Return the oldest, or None if there is none within so many seconds; DeviceError if
        lost.
        """
        with self._link.changed:
            self._link.wait_until(lambda: bool(self._packets), timeout)
            return self._packets.popleft().packet if self._packets else None


class Link:
    """Runs a session until it is closed."""

    def __init__(
        self,
        port: Port,
        control: Control,
        receiver: Receiver,
        clock: Callable[[], float],
        log: TrafficLog | None = None,
    ) -> None:
        self.control = control
        self.changed = threading.Condition(threading.RLock())
        """Guards `control`; notified when a packet or an end has come."""
        self._port, self._receiver, self._clock, self._log = port, receiver, clock, log
        self._owner = port if isinstance(port, LineProcess) else None
        self._lease_end: float | None = None
        self._out = threading.Lock()
        self._others = threading.Lock()
        self._spacing = FAST_SPACING if control.reports_motors else SLOW_SPACING
        self._other_at = 0.0
        self._inboxes: dict[int, Inbox] = {}
        self._callbacks: list[Callable[[Problem], None]] = []
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._threads = [
            threading.Thread(target=self._read, name="pioneer-reader", daemon=True),
            threading.Thread(target=self._write, name="pioneer-writer", daemon=True),
        ]

    def start(self) -> None:
        """Start both threads."""
        for thread in self._threads:
            thread.start()

    def wake(self) -> None:
        """Wake the writer, which checks what is to be sent."""
        self._wake.set()

    def inbox(self, kind: int) -> Inbox:
        """Return the queue for packets of a kind, from now on; one for each kind."""
        with self.changed:
            return self._inboxes.setdefault(kind, Inbox(self))

    def on_problem(self, callback: Callable[[Problem], None]) -> None:
        """Call back with each problem, from the reader's thread."""
        with self.changed:
            self._callbacks.append(callback)

    def wait_until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Return whether it holds within so many seconds; the lock is held. DeviceError if lost."""
        deadline = time.monotonic() + timeout
        while not condition():
            self.control.check()
            if self._closing.is_set():
                raise DeviceError("the connection to the robot was closed")
            left = deadline - time.monotonic()
            if left <= 0:
                return False
            self.changed.wait(left)
        return True

    def send(self, *packets: Packet, slowly: bool = False) -> None:
        """Send commands one after the other, as fast as the robot accepts them.

        `slowly`: as fast as the slowest firmware accepts them.
        """
        for packet in packets:
            with self.changed:
                self.control.check()
            self.send_anyway(packet, slowly=slowly)
        with self.changed:
            self.control.check()

    def send_anyway(self, *packets: Packet, slowly: bool = False) -> None:
        """Send commands also if the link is lost: they may or may not arrive."""
        spacing = SLOW_SPACING if slowly else self._spacing
        for packet in packets:
            with self._others:
                # Not under the lock for everything sent: zeros must not wait.
                if (pause := self._other_at + spacing - time.monotonic()) > 0:
                    time.sleep(pause)
                self._other_at = time.monotonic()
                with self._out:
                    with self.changed:
                        now = self._clock()
                        data = _join_packets(
                            [*self.control.motion.list_packets_before(now), packet]
                        )
                        self.control.note_outgoing(packet)
                        self._note(now, data)
                    self._put(data)

    def ask(self, question: Packet, kind: int, *, tries: int, each: float) -> Packet | None:
        """Return the answer of a kind to a request, or None; `tries` requests, `each` s apart."""
        inbox = self.inbox(kind)
        inbox.clear()
        for _ in range(tries):
            self.send(question)
            if (answer := inbox.take(each)) is not None:
                return answer
        return None

    def close(self) -> None:
        """End the threads and close the port; more than once does no harm."""
        self._closing.set()
        self._wake.set()
        with self.changed:
            self.changed.notify_all()
        for thread in self._threads:
            if thread.is_alive() and thread is not threading.current_thread():
                thread.join(JOIN_TIMEOUT)
        self._port.close()
        self._notify()

    def _read(self) -> None:
        try:
            while not self._closing.is_set():
                self._read_once()
                self._notify()
        except DeviceError as error:
            self._fail(error)
            self._notify()
        except Exception as error:
            LOGGER.exception("the reader of the robot's line failed")
            self._fail(DeviceError(f"the reader of the robot's line failed: {error!r}"))
            self._notify()

    def _read_once(self) -> None:
        data = self._port.read(READ_TIMEOUT)
        now, strange = self._clock(), self._receiver.strange
        if data:
            received = self._receiver.feed(data, now)
        elif (given_up := self._receiver.idle(now)) is not None:
            received = given_up
        else:
            received = None
        with self.changed:
            if self._log is not None and received is not None:
                self._log.incoming(now, data)
            for each in received or ():
                self.control.take(each)
                if (inbox := self._inboxes.get(each.packet.kind)) is not None:
                    inbox.put(each)
            self.control.looked(now, damaged=self._receiver.strange > strange)
            if received or self.control.lost:
                self.changed.notify_all()

    def _write(self) -> None:
        try:
            while not self._closing.is_set():
                self._wake.clear()
                with self._out:
                    with self.changed:
                        lost_before = self.control.lost
                        now = self._clock()
                        data = _join_packets(self.control.advance(now))
                        self._note(now, data)
                        due = self.control.due
                        if self.control.lost is not lost_before:
                            self.changed.notify_all()
                        lease_end = self.control.motion.lease_end
                        stopping = _join_packets(self.control.motion.stopping())
                    self._put(data, lease_end, stopping)
                self._wake.wait(min(LOOK_EVERY, max(0.001, due - self._clock())))
        except Exception as error:
            LOGGER.exception("the writer of the robot's line failed")
            with self._out:
                self._put(_join_packets([make_plain_command(Command.STOP)]))
            self._fail(DeviceError(f"the writer of the robot's line failed: {error!r}"))

    def _note(self, now: float, data: bytes) -> None:
        """Log what is sent under the lock, so that the log has the order of `Control`."""
        if data and self._log is not None:
            self._log.log_outgoing(now, data)

    def _put(
        self, data: bytes, lease_end: float | None = None, stopping: bytes | None = None
    ) -> None:
        """Write to the line; of what is sent with `stopping`, the end of its lease has changed."""
        try:
            if self._owner is not None and stopping is not None:
                if lease_end is not None and lease_end != self._lease_end:
                    self._owner.hold(lease_end, stopping)
                elif lease_end is None and self._lease_end is not None:
                    self._owner.release()
                self._lease_end = lease_end
            if data:
                self._port.write(data)
        except DeviceError as error:
            self._fail(error)

    def _fail(self, error: DeviceError) -> None:
        with self.changed:
            if not self._closing.is_set():
                self.control.fail(error, Cause.LINK_LOST, self._clock())
            self.changed.notify_all()

    def _notify(self) -> None:
        with self.changed:
            problems, callbacks = self.control.take_new_problems(), tuple(self._callbacks)
        for problem in problems:
            LOGGER.info("%s", problem)
            for callback in callbacks:
                try:
                    callback(problem)
                except Exception as error:
                    LOGGER.exception("a callback for the robot's problems failed")
                    text = f"a callback for problems failed: {error!r}"
                    with self.changed:
                        if problem.cause is not Cause.CALLBACK:
                            self.control.say(Problem(Cause.CALLBACK, text, self._clock()))


def _join_packets(packets: Iterable[Packet]) -> bytes:
    return b"".join(packet.to_bytes() for packet in packets)


LARGEST_REQUEST = 200
"""Bytes that GETAUX may ask for, on P2OS (Pioneer 2 manual, page 48)."""
ASK_AGAIN = 0.4
"""Seconds after which a request may have been lost: 200 bytes take 0.2 s at 9600 baud."""


@dataclass(frozen=True, slots=True)
class _Numbers:
    send: Command
    get: Command
    report: Report


PORTS = {
    1: _Numbers(Command.TTY2, Command.GETAUX, Report.SERAUX),
    2: _Numbers(Command.TTY3, Command.GETAUX2, Report.SERAUX2),
    3: _Numbers(Command.TTY4, Command.GETAUX3, Report.SERAUX3),
}


class AuxLine:
    """A line of bytes to the device on an AUX port, at the port's own speed (9600 mostly).

    ValueError if there is no such port.
    """

    def __init__(self, link: Link, number: int = 1) -> None:
        if number not in PORTS:
            raise ValueError(f"there is no AUX port {number}: 1, 2 and 3 there are")
        self._link, self._numbers = link, PORTS[number]
        self.name = f"AUX{number}"
        self._inbox = link.inbox(self._numbers.report)
        self._waiting = bytearray()

    def flush(self) -> None:
        """Discard what the device has sent so far."""
        self._link.send(make_integer_command(self._numbers.get, 0))
        self._inbox.clear()
        self._waiting.clear()

    def send(self, data: bytes) -> None:
        """Send bytes to the device."""
        for start in range(0, len(data), LARGEST_TEXT):
            chunk = data[start : start + LARGEST_TEXT]
            self._link.send(make_text_command(self._numbers.send, chunk))

    def receive(self, count: int, timeout: float) -> bytes:
        """Read exactly `count` bytes from the device; raise DeviceTimeout if they do not come."""
        deadline = time.monotonic() + timeout
        asked_at = None
        while len(self._waiting) < count:
            now = time.monotonic()
            if asked_at is None or now - asked_at >= ASK_AGAIN:
                wanted = min(count - len(self._waiting), LARGEST_REQUEST)
                self._link.send(make_integer_command(self._numbers.get, wanted))
                asked_at = now
            left = min(deadline, asked_at + ASK_AGAIN) - time.monotonic()
            packet = self._inbox.take(max(0.0, left))
            if packet is not None:
                self._waiting += packet.payload
                asked_at = None
            elif time.monotonic() >= deadline:
                raise DeviceTimeout(
                    f"{self.name} of the robot: {len(self._waiting)} of {count} bytes came within"
                    f" {timeout:.1f} s; check the device's power, cable and speed, and the port"
                )
        data = bytes(self._waiting[:count])
        del self._waiting[:count]
        return data

    def close(self) -> None:
        """Do nothing: the robot's connection closes the line."""
