"""The driver of a Canon VC-C4 or VC-C50i.

Its answers acknowledge a command, not its completion: a move has ended when two successive reports
of the position are equal. A head whose cable leaves the CTS line low obeys and never answers; it is
then driven open-loop, with the time that its moves take at the speeds that were set.

Commands are sent one at a time, and repeated where an answer is lost or the head is busy. Answers
are requested in lengths that the robot's microcontroller can return: six bytes, the length of an
error, and then the rest.
"""

import logging
import math
from collections.abc import Callable
from typing import TypeVar

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.canon import (
    ACK_BYTES,
    ANSWER_HEADER,
    COUNTS_PER_DEGREE,
    END,
    POSITION_BYTES,
    REACH,
    ZOOM_BYTES,
    Answer,
    CanonCommand,
    CanonError,
    CanonSyntaxError,
    angles_to_counts,
    counts_to_angles,
    encode_angle,
    encode_command,
    encode_hexadecimal,
    number,
    parse_answer,
    parse_position,
)
from facetlog.robot.head.head import (
    READ_ATTEMPTS,
    Clock,
    Counts,
    HeadLimits,
    HeadState,
    ask_repeatedly,
    wait_until_still,
)

T = TypeVar("T")

REPLY_S = 1.0
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
        """Return the answer to a command, with so many bytes of data if it is no error.

        A command whose answer was lost is sent again, so it must be idempotent. DeviceTimeout if
        the head never answers, DeviceError if no answer can be decoded.
        """

        def send() -> Answer:
            self._line.flush()
            self._line.send(encode_command(command, parameters))
            return self._answer(command, data)

        checks = ", that it runs at 9600 baud, and that the CTS line of its port (pin 2) is high"
        return ask_repeatedly(
            send, lambda: self._clock.sleep(QUIET_S), unreadable=CanonSyntaxError, checks=checks
        )

    def _answer(self, command: CanonCommand, data: int) -> Answer:
        frame = self._line.receive(ACK_BYTES, REPLY_S)
        if not frame.startswith(ANSWER_HEADER):
            raise CanonSyntaxError(f"{frame.hex(' ')} begins no answer")
        if data and frame[-1] != END:
            frame += self._line.receive(data, REPLY_S)
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
        """Return the answer as read by `decode`; the command is repeated while the head is busy.

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
                        if garbled == READ_ATTEMPTS:
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
        """Send a command to a head that does not answer, and wait until it can be done."""
        self._line.flush()
        self._line.send(encode_command(command, parameters))
        self._clock.sleep(UNANSWERED_S + wait)

    def close(self) -> None:
        self._line.close()


logger = logging.getLogger(__name__)

STARTING_S = 25.0
"""For switching on and homing, seconds: each takes 4 to 5 (ARIA, ArVCC4.h)."""
SWITCHING_ON_S = 5.0
MIDDLE_S = 6.0
ANSWER_S = 10.0
"""For its position, seconds: it does not report it while it homes."""
ZOOM_S = 15.0
"""From end to end of the zoom, seconds, with room to spare."""
WIDEST = 0
UNREPORTED_ZOOM_S = 5.0
"""The same for a head that cannot report its position."""
NEAR = (math.ceil(0.5 * COUNTS_PER_DEGREE),) * 2
"""Tolerance of a commanded position, counts: half a degree."""
NEAR_ZOOM = (16,)
"""The same for the zoom, counts: below one hundredth of the range."""
ATTEMPTS = 3
"""Attempts at a move that does not take the head to its goal."""
MARGIN_S = 0.5
"""Beyond the time of a move at an even speed, seconds, for speeding up and slowing down."""
YES = b"1"
THIS_LINE = b"0"
FIRST = b"0"
SETTINGS: tuple[tuple[CanonCommand, bytes], ...] = (
    (CanonCommand.PAN_SPEED, encode_hexadecimal(REACH.fastest_pan, 3)),
    (CanonCommand.TILT_SPEED, encode_hexadecimal(REACH.fastest_tilt, 3)),
    (CanonCommand.RANGE, b"1" + encode_angle(REACH.tilt_lowest) + encode_angle(REACH.tilt_highest)),
)
"""What is set after switching on: as fast as it can, and as far up as it can."""


def _nothing(data: bytes) -> bytes:
    return data


class CanonVcC4:
    """A Canon head on a line, at its widest zoom.

    `answers` says whether its cable lets it answer; None: found out at the start.
    """

    def __init__(
        self,
        line: ByteLine,
        *,
        answers: bool | None = None,
        clock: Clock | None = None,
    ) -> None:
        self._clock = clock or Clock()
        self._line = CanonLine(line, self._clock)
        self._answers = answers
        self._zoom = WIDEST
        self._commanded: Counts | None = None
        """The last commanded position of a head that does not answer, known once it is started."""

    @property
    def answers(self) -> bool:
        """Whether it answers; assumed until `start` has found out."""
        return self._answers is not False

    @property
    def limits(self) -> HeadLimits:
        """How far it can turn, be it a VC-C4 or a VC-C50i."""
        return REACH.limits

    def start(self) -> None:
        """Switch it on, home it, set its speeds, range and widest zoom.

        DeviceTimeout if it does not get ready, or does not answer though it was stated that it can.
        """
        if self._answers is None:
            self._answers = self._find_out()
        if not self._answers:
            self._start_unanswered()
            return
        deadline = self._clock.now() + STARTING_S
        starting: tuple[tuple[CanonCommand, bytes], ...] = (
            (CanonCommand.CONTROL, THIS_LINE),
            (CanonCommand.POWER, YES),
            (CanonCommand.INITIALIZE, FIRST),
        )
        for command, parameters in starting:
            self._order(command, parameters, deadline, starting=True)
        self._position(deadline, starting=True)
        for command, parameters in SETTINGS:
            self._order(command, parameters, deadline)
        zoomed_by = self._clock.now() + ZOOM_S
        (self._zoom,) = self._perform(
            CanonCommand.ZOOM,
            encode_hexadecimal(WIDEST, 4),
            lambda: self._read_zoom_counts(zoomed_by),
            (WIDEST,),
            NEAR_ZOOM,
            zoomed_by,
        )

    def look(self, pan: float, tilt: float, timeout: float = 10.0) -> HeadState:
        """Turn to `pan` and `tilt` (radians) and return where it stands once it is still.

        InputError beyond its limits; DeviceTimeout if it does not answer, or still moves after
        `timeout` seconds; DeviceError if it refuses or comes to stand elsewhere.
        """
        self.limits.check(pan, tilt)
        goal_pan, goal_tilt = angles_to_counts(pan, tilt)
        goal_pan = max(-REACH.pan_limit, min(goal_pan, REACH.pan_limit))
        goal_tilt = max(REACH.tilt_lowest, min(goal_tilt, REACH.tilt_highest))
        goal = (goal_pan, goal_tilt)
        if not self.answers:
            return self._look_unanswered(goal, timeout)
        deadline = self._clock.now() + timeout
        where = encode_angle(goal_pan) + encode_angle(goal_tilt)
        here = self._perform(
            CanonCommand.MOVE, where, lambda: self._position(deadline), goal, NEAR, deadline
        )
        return self._state(here)

    def close(self) -> None:
        """Close the line; the head stays as it stands."""
        self._line.close()

    def _state(self, here: Counts) -> HeadState:
        pan, tilt = here
        return HeadState(
            *counts_to_angles(pan, tilt), self._zoom, self._clock.now(), reported=self.answers
        )

    def _find_out(self) -> bool:
        try:
            self._line.ask(CanonCommand.CONTROL, THIS_LINE)
        except DeviceTimeout as exc:
            logger.warning(
                "%s; its moves are not confirmed, and the pictures' pan and tilt are the commanded"
                " angles, not reported ones",
                exc,
            )
            return False
        return True

    def _start_unanswered(self) -> None:
        # Twice, for a head that is off may take neither before the other.
        for wait in (SWITCHING_ON_S, 0.0):
            self._line.send_unanswered(CanonCommand.CONTROL, THIS_LINE)
            self._line.send_unanswered(CanonCommand.POWER, YES, wait)
        self._line.send_unanswered(CanonCommand.INITIALIZE, FIRST, MIDDLE_S)
        for command, parameters in SETTINGS:
            self._line.send_unanswered(command, parameters)
        self._line.send_unanswered(
            CanonCommand.ZOOM, encode_hexadecimal(WIDEST, 4), UNREPORTED_ZOOM_S
        )
        self._commanded = (0, 0)

    def _look_unanswered(self, goal: Counts, timeout: float) -> HeadState:
        if self._commanded is None:
            ways: Counts = (2 * REACH.pan_limit, REACH.tilt_highest - REACH.tilt_lowest)
        else:
            ways = tuple(abs(a - b) for a, b in zip(goal, self._commanded, strict=True))
        wait = max(ways[0] / REACH.fastest_pan, ways[1] / REACH.fastest_tilt) + MARGIN_S
        if wait > timeout:
            raise DeviceTimeout(
                f"the camera head needs {wait:.1f} s for this and cannot say when it is"
                f" done: give it more than {timeout:.1f} s"
            )
        # It accepts no move during another one, and cannot report that.
        self._line.send_unanswered(CanonCommand.DRIVE, FIRST)
        self._line.send_unanswered(
            CanonCommand.MOVE, b"".join(encode_angle(counts) for counts in goal), wait
        )
        self._commanded = goal
        return self._state(goal)

    def _order(
        self, command: CanonCommand, parameters: bytes, deadline: float, *, starting: bool = False
    ) -> None:
        self._line.insist(
            command, parameters, decode=_nothing, deadline=deadline, starting=starting
        )

    def _position(self, deadline: float, *, starting: bool = False) -> Counts:
        return self._line.insist(
            CanonCommand.POSITION_REQUEST,
            data=POSITION_BYTES - ACK_BYTES,
            decode=parse_position,
            deadline=deadline,
            starting=starting,
        )

    def _read_zoom_counts(self, deadline: float) -> Counts:
        counts = self._line.insist(
            CanonCommand.ZOOM_REQUEST,
            FIRST,
            ZOOM_BYTES - ACK_BYTES,
            decode=number,
            deadline=deadline,
        )
        return (counts,)

    def _perform(
        self,
        command: CanonCommand,
        parameters: bytes,
        read: Callable[[], Counts],
        target: Counts,
        near: Counts,
        deadline: float,
    ) -> Counts:
        """Return the position by `read` once the head has carried the command out."""
        here: Counts = ()
        for _ in range(ATTEMPTS):
            self._order(command, parameters, deadline)
            here, there = wait_until_still(read, target, near, deadline, self._clock)
            if there:
                return here
        raise DeviceError(
            f"the camera head stands at {here} of its counts and was sent to {target}: see whether"
            " something holds it"
        )
