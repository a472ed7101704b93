"""One inquiry or command at a time to a Sony head, with retries where an answer is lost.

Answers are requested in lengths that work through the robot's microcontroller as well: the shortest
possible answer first, then the rest.
"""

from collections.abc import Callable
from typing import Final, TypeVar

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.settling import Clock
from facetlog.robot.head.visca import (
    BROADCAST,
    END,
    AddressSet,
    Command,
    Fixed,
    Inquiry,
    ViscaSyntaxError,
    to_bytes,
)
from facetlog.robot.head.visca_replies import (
    ACK_BYTES,
    ERROR_BYTES,
    Ack,
    Completed,
    Failed,
    Information,
    Reply,
    parse_reply,
)

__all__ = ["ViscaLine"]

T = TypeVar("T")

ATTEMPTS: Final = 5
"""Attempts before the head counts as silent: where one byte in fifty is lost, five answers of
eleven bytes in a row are spoilt once in three thousand times."""
ANSWER_S = 1.0
"""Time-out of an answer, seconds: a head takes a picture's time (17 ms) and the bytes at 9600 baud
12 ms; through the robot each step waits for its cycle of up to 100 ms."""
QUIET_S = 0.15
"""Pause before a retry, seconds: the rest of a garbled answer has arrived by then."""
ADDRESSES_BYTES = 4
FRAME_BYTES = 3
"""Bytes of an answer besides its data."""


class ViscaLine:
    """The line to a Sony head, in whole answers; every wait has a time-out."""

    def __init__(self, line: ByteLine, clock: Clock, address: int = 1) -> None:
        self._line, self._clock, self._address = line, clock, address

    def set_addresses(self) -> None:
        """Numbers the heads on the line; one that already has a number may not answer."""
        self._line.flush()
        self._line.send(to_bytes(AddressSet()))
        try:
            self._line.receive(ADDRESSES_BYTES, ANSWER_S)
        except DeviceTimeout:
            return

    def ask(self, inquiry: Inquiry, length: int, decode: Callable[[bytes], T]) -> T | Failed:
        """The answer to an inquiry as read by `decode`, or why there is none.

        The whole answer has `length` bytes. DeviceTimeout if the head never answers, DeviceError if
        no answer can be decoded.
        """

        def answer() -> T | Failed:
            reply = self._receive(ERROR_BYTES, length)
            if isinstance(reply, Failed):
                return reply
            if isinstance(reply, Information) and len(reply.data) == length - FRAME_BYTES:
                return decode(reply.data)
            raise ViscaSyntaxError(f"{reply} does not answer {inquiry.name}")

        return self._persist(inquiry, answer)

    def command(self, command: Command) -> Ack | Failed:
        """The acknowledgement or refusal of a command; `completed` waits for its end.

        A command whose answer was lost is sent again, so it must be idempotent. Errors as `ask`.
        """

        def answer() -> Ack | Failed:
            reply = self._receive(ACK_BYTES, ERROR_BYTES)
            if isinstance(reply, Ack | Failed):
                return reply
            raise ViscaSyntaxError(f"{reply} does not acknowledge a command")

        return self._persist(command, answer)

    def completed(self, ack: Ack, timeout: float) -> bool:
        """Whether the head reported completion of the command; False if it reported nothing."""
        try:
            reply = self._receive(ACK_BYTES, ERROR_BYTES, timeout)
        except (DeviceTimeout, ViscaSyntaxError):
            return False
        return reply == Completed(ack.socket)

    def clear(self) -> None:
        """Clears the commands in progress, if the head can; errors as `ask`.

        One that does not know this command answers with an error, and is as ready as before.
        """

        def answer() -> None:
            reply = self._receive(ACK_BYTES, ERROR_BYTES)
            if not isinstance(reply, Information | Failed):
                raise ViscaSyntaxError(f"{reply} does not answer a clear")

        self._persist(Fixed.CLEAR, answer)

    def pause(self) -> None:
        """Waits before a retry."""
        self._clock.sleep(QUIET_S)

    def close(self) -> None:
        """Closes the line."""
        self._line.close()

    def _receive(self, first: int, whole: int, timeout: float = ANSWER_S) -> Reply:
        """The next answer, of `first` or `whole` bytes."""
        data = self._line.receive(first, timeout)
        if data[0] not in (0x80 + 0x10 * self._address, 0x80 | BROADCAST):
            raise ViscaSyntaxError(f"{data.hex(' ')} begins no answer")
        if whole > first and data[-1] != END:
            data += self._line.receive(whole - first, ANSWER_S)
        return parse_reply(data, self._address)

    def _persist(self, command: Command, answer: Callable[[], T]) -> T:
        fault: Exception | None = None
        for attempt in range(ATTEMPTS):
            if attempt:
                self.pause()
            self._line.flush()
            self._line.send(to_bytes(command, self._address))
            try:
                return answer()
            except (DeviceTimeout, ViscaSyntaxError) as exc:
                if not isinstance(fault, ViscaSyntaxError):
                    fault = exc
        if isinstance(fault, ViscaSyntaxError):
            raise DeviceError(
                f"the camera head answers what cannot be read ({fault}): check that the line runs"
                " at 9600 baud and that nothing else talks on it"
            ) from fault
        raise DeviceTimeout(
            "the camera head does not answer: check that it has power, that its cable is in the"
            " port that was named (of the robot: AUX1, AUX2 or AUX3), and that it runs at 9600 baud"
        ) from fault
