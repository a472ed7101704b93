"""One command at a time to a Canon head, with retries where its answer is lost or it is busy.

Answers are requested in lengths that the robot's microcontroller can return: six bytes, the length
of an error, and then the rest.
"""

from collections.abc import Callable
from typing import Final, TypeVar

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.canon import (
    ACK_BYTES,
    ANSWER_HEADER,
    END,
    Answer,
    CanonCommand,
    CanonError,
    CanonSyntaxError,
    command_to_bytes,
    parse_answer,
)
from facetlog.robot.head.settling import Clock

__all__ = ["CanonLine"]

T = TypeVar("T")

ATTEMPTS: Final = 5
"""Attempts before the head counts as silent: where one byte in fifty is lost, five answers of
fourteen bytes in a row are spoilt once in a thousand times."""
ANSWER_S = 1.0
"""Time-out of an answer, seconds: the head answers within 0.3 (ARIA, ArVCC4.h), and through the
robot each step waits for its cycle of up to 0.1."""
QUIET_S = 0.15
"""Pause before a retry, seconds: the rest of a garbled answer has arrived by then."""
UNANSWERED_S = 0.4
"""Pause after a command to a head that does not answer, seconds: it accepts no other before it is
done with the last, which takes 0.3 at most (ARIA waits 0.3 to 0.4)."""


class CanonLine:
    """The line to a Canon head, in whole answers; every wait has a time-out."""

    def __init__(self, line: ByteLine, clock: Clock) -> None:
        self._line, self._clock = line, clock

    def ask(self, command: CanonCommand, parameters: bytes = b"", data: int = 0) -> Answer:
        """The answer to a command, with so many bytes of data if it is no error.

        A command whose answer was lost is sent again, so it must be idempotent. DeviceTimeout if
        the head never answers, DeviceError if no answer can be decoded.
        """
        fault: Exception | None = None
        for attempt in range(ATTEMPTS):
            if attempt:
                self._clock.sleep(QUIET_S)
            self._line.flush()
            self._line.send(command_to_bytes(command, parameters))
            try:
                return self._answer(command, data)
            except (DeviceTimeout, CanonSyntaxError) as exc:
                if not isinstance(fault, CanonSyntaxError):
                    fault = exc
        if isinstance(fault, CanonSyntaxError):
            raise DeviceError(
                f"the camera head answers what cannot be read ({fault}): check that the line runs"
                " at 9600 baud and that nothing else talks on it"
            ) from fault
        raise DeviceTimeout(
            "the camera head does not answer: check that it has power, that its cable is in the"
            " port that was named (of the robot: AUX1, AUX2 or AUX3), that it runs at 9600 baud,"
            " and that the CTS line of its port (pin 2) is high"
        ) from fault

    def _answer(self, command: CanonCommand, data: int) -> Answer:
        frame = self._line.receive(ACK_BYTES, ANSWER_S)
        if not frame.startswith(ANSWER_HEADER):
            raise CanonSyntaxError(f"{frame.hex(' ')} begins no answer")
        if data and frame[-1] != END:
            frame += self._line.receive(data, ANSWER_S)
        answer = parse_answer(frame)
        if answer.error is CanonError.NONE and len(answer.data) != data:
            raise CanonSyntaxError(f"{frame.hex(' ')} does not answer {command.name}")
        return answer

    def insist(
        self,
        command: CanonCommand,
        parameters: bytes = b"",
        data: int = 0,
        *,
        decode: Callable[[bytes], T],
        deadline: float,
        starting: bool = False,
    ) -> T:
        """The answer as read by `decode`; the command is repeated while the head is busy.

        While it is `starting` it may report the wrong mode, too. DeviceTimeout at the deadline,
        DeviceError if it refuses.
        """
        garbled = 0
        while True:
            answer = self.ask(command, parameters, data)
            match answer.error:
                case CanonError.NONE:
                    try:
                        return decode(answer.data)
                    except CanonSyntaxError as exc:
                        garbled += 1
                        if garbled == ATTEMPTS:
                            raise DeviceError(
                                f"the camera head answers {command.name} with what cannot be read:"
                                f" {exc}"
                            ) from exc
                case CanonError.PARAMETER:
                    raise DeviceError(
                        f"the camera head refuses {command.name} {parameters.decode()}: check that"
                        " it is a VC-C4 or VC-C50i, mounted upright"
                    )
                case CanonError.MODE if not starting:
                    raise DeviceError(
                        "the camera head was switched off or taken over by its remote control:"
                        " start it again"
                    )
            if self._clock.now() > deadline:
                raise DeviceTimeout(
                    f"the camera head answers, and is still not ready for {command.name}: give it"
                    " more time, or see whether something holds it"
                )
            self._clock.sleep(QUIET_S)

    def send_unanswered(
        self, command: CanonCommand, parameters: bytes = b"", wait: float = 0.0
    ) -> None:
        """Sends a command to a head that does not answer, and waits until it can be done."""
        self._line.flush()
        self._line.send(command_to_bytes(command, parameters))
        self._clock.sleep(UNANSWERED_S + wait)

    def close(self) -> None:
        """Closes the line."""
        self._line.close()
