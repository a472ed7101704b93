"""The driver of a Sony EVI-D30 or D31, and of its kin EVI-D70 and EVI-D100, over VISCA.

Absolute moves only, one at a time: rounding errors of relative ones add up (EVI-D100 manual, page
45). A move ends with the head's completion message or, where that is lost, with two equal reports
of its position. Answers are requested in lengths that work through the robot's microcontroller as
well: the shortest possible answer first, then the rest.
"""

import math
from collections.abc import Callable
from typing import TypeVar

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.head import (
    Clock,
    Counts,
    HeadLimits,
    HeadState,
    ask_repeatedly,
    wait_until_still,
)
from facetlog.robot.head.sony_models import EVI_D30, SONY_MODELS, SonyModel
from facetlog.robot.head.visca import (
    ACK_BYTES,
    BROADCAST,
    CAMERA_1,
    END,
    ERROR_BYTES,
    POSITION_BYTES,
    POWER_BYTES,
    VERSION_BYTES,
    ZOOM_BYTES,
    AbsoluteMove,
    Ack,
    AddressSet,
    Command,
    Completed,
    Failed,
    Fixed,
    Information,
    Inquiry,
    Power,
    Reply,
    Version,
    ViscaError,
    ViscaSyntaxError,
    ZoomTo,
    number,
    parse_position,
    parse_reply,
    to_bytes,
)

T = TypeVar("T")

REPLY_S = 1.0
"""Time-out of an answer, seconds: a head takes a picture's time (17 ms) and the bytes at 9600 baud
12 ms; through the robot each step waits for its cycle of up to 100 ms."""
QUIET_S = 0.15
"""Pause before a retry, seconds: the rest of a garbled answer has arrived by then."""
ADDRESSES_BYTES = 4
FRAME_BYTES = 3
"""Bytes of an answer besides its data."""


class ViscaLine:
    """The line to a Sony head, in whole answers; every wait has a time-out."""

    def __init__(self, line: ByteLine, clock: Clock) -> None:
        self._line, self._clock = line, clock

    def set_addresses(self) -> None:
        """Number the heads on the line; one that already has a number may not answer."""
        self._line.flush()
        self._line.send(to_bytes(AddressSet()))
        try:
            self._line.receive(ADDRESSES_BYTES, REPLY_S)
        except DeviceTimeout:
            return

    def ask(self, inquiry: Inquiry, length: int, decode: Callable[[bytes], T]) -> T | Failed:
        """Return the answer to an inquiry as read by `decode`, or why there is none.

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
        """Return the acknowledgement or refusal of a command; `completed` waits for its end.

        A command whose answer was lost is sent again, so it must be idempotent. Errors as `ask`.
        """

        def answer() -> Ack | Failed:
            reply = self._receive(ACK_BYTES, ERROR_BYTES)
            if isinstance(reply, Ack | Failed):
                return reply
            raise ViscaSyntaxError(f"{reply} does not acknowledge a command")

        return self._persist(command, answer)

    def completed(self, ack: Ack, timeout: float) -> bool:
        """Return whether the head reported completion of the command; False if it reported
        nothing.
        """
        try:
            reply = self._receive(ACK_BYTES, ERROR_BYTES, timeout)
        except (DeviceTimeout, ViscaSyntaxError):
            return False
        return reply == Completed(ack.socket)

    def clear(self) -> None:
        """Clear the commands in progress, if the head can; errors as `ask`.

        One that does not know this command answers with an error, and is as ready as before.
        """

        def answer() -> None:
            reply = self._receive(ACK_BYTES, ERROR_BYTES)
            if not isinstance(reply, Information | Failed):
                raise ViscaSyntaxError(f"{reply} does not answer a clear")

        self._persist(Fixed.CLEAR, answer)

    def pause(self) -> None:
        self._clock.sleep(QUIET_S)

    def close(self) -> None:
        self._line.close()

    def _receive(self, first: int, whole: int, timeout: float = REPLY_S) -> Reply:
        """Return the next answer, of `first` or `whole` bytes."""
        data = self._line.receive(first, timeout)
        if data[0] not in (CAMERA_1, 0x80 | BROADCAST):
            raise ViscaSyntaxError(f"{data.hex(' ')} begins no answer")
        if whole > first and data[-1] != END:
            data += self._line.receive(whole - first, REPLY_S)
        return parse_reply(data)

    def _persist(self, command: Command, answer: Callable[[], T]) -> T:
        def send() -> T:
            self._line.flush()
            self._line.send(to_bytes(command))
            return answer()

        checks = ", and that it runs at 9600 baud"
        return ask_repeatedly(send, self.pause, unreadable=ViscaSyntaxError, checks=checks)


ATTEMPTS = 3
"""Attempts at a command that the head refuses, or that does not take it to its goal."""
STARTING_S = 20.0
"""For switching on, seconds: an EVI-D70 has its picture 7 s after homing (manual, page 52)."""
COMPLETION_S = 4.0
"""For the completion of a move, seconds: from limit to limit takes 2.5 s at 80°/s. After that the
position is polled."""
NEAR_DEG = 0.5
"""Tolerance of a commanded position, degrees: several counts, less than any view needs; the
reported position is what is recorded."""
NEAR_ZOOM = 8
"""The same for the zoom, counts: below one hundredth of the range."""
ZOOM_S = 15.0
"""From end to end of the zoom, seconds, with room to spare."""
ON = bytes([2])
WIDEST = 0


class SonyEviD30:
    """A Sony head on a line, at its widest zoom."""

    def __init__(self, line: ByteLine, *, clock: Clock | None = None) -> None:
        self._clock = clock or Clock()
        self._line = ViscaLine(line, self._clock)
        self._model: SonyModel = EVI_D30
        self._zoom = WIDEST

    @property
    def model(self) -> SonyModel:
        """The head's model; an EVI-D30 until `start` has inquired."""
        return self._model

    @property
    def limits(self) -> HeadLimits:
        """How far it can turn."""
        return self._model.limits

    def start(self) -> None:
        """Switch it on if it is off, inquire its model and set the widest zoom.

        DeviceTimeout if it does not answer or does not get ready, DeviceError if the model's scale
        of angles is not known.
        """
        self._line.set_addresses()
        self._line.clear()
        self._switch_on(self._clock.now() + STARTING_S)
        self._model = self._ask_model()
        zoomed_by = self._clock.now() + ZOOM_S
        (self._zoom,) = self._perform(
            ZoomTo(WIDEST), self._read_zoom_counts, (WIDEST,), (NEAR_ZOOM,), zoomed_by
        )

    def look(self, pan: float, tilt: float, timeout: float = 10.0) -> HeadState:
        """Turn to `pan` and `tilt` (radians) and return where it stands once it is still.

        InputError beyond its limits; DeviceTimeout if it does not answer, or still moves after
        `timeout` seconds; DeviceError if it refuses or comes to stand elsewhere.
        """
        self.limits.check(pan, tilt)
        deadline = self._clock.now() + timeout
        goal_pan, goal_tilt = self._model.counts(pan, tilt)
        goal_pan = max(-self._model.pan_limit, min(goal_pan, self._model.pan_limit))
        goal_tilt = max(self._model.tilt_lowest, min(goal_tilt, self._model.tilt_highest))
        near = (
            math.ceil(NEAR_DEG * self._model.pan_per_degree),
            math.ceil(NEAR_DEG * self._model.tilt_per_degree),
        )
        move = AbsoluteMove(goal_pan, goal_tilt)
        here_pan, here_tilt = self._perform(
            move, self._position, (goal_pan, goal_tilt), near, deadline
        )
        angles = self._model.angles(here_pan, here_tilt)
        return HeadState(*angles, self._zoom, self._clock.now())

    def close(self) -> None:
        """Close the line; the head stays as it stands."""
        self._line.close()

    def _switch_on(self, deadline: float) -> None:
        """Wait until it reports its position, which it does not while it is off or starting."""
        while True:
            power = self._line.ask(Inquiry.POWER, POWER_BYTES, bytes)
            if power in (ON, Failed(ViscaError.SYNTAX)):  # without stand-by there is nothing to ask
                position = self._line.ask(Inquiry.POSITION, POSITION_BYTES, parse_position)
                if not isinstance(position, Failed):
                    return
            else:
                self._line.command(Power(True))
            if self._clock.now() > deadline:
                raise DeviceTimeout(
                    f"the camera head answers, and is not ready {STARTING_S:.0f} s after it was"
                    " switched on: switch its power off and on, and see whether something holds it"
                )
            self._line.pause()

    def _ask_model(self) -> SonyModel:
        version = self._insist_on_answer(Inquiry.VERSION, VERSION_BYTES, Version.of)
        model = SONY_MODELS.get(version.model)
        if model is None:
            known = ", ".join(f"{model.name} ({word:04X})" for word, model in SONY_MODELS.items())
            raise DeviceError(
                f"the camera head is of model {version.model:04X}, whose counts to a degree are not"
                f" known here: use one of {known}, or switch it to its D30/D31 mode"
            )
        return model

    def _position(self) -> Counts:
        return self._insist_on_answer(Inquiry.POSITION, POSITION_BYTES, parse_position)

    def _read_zoom_counts(self) -> Counts:
        return (self._insist_on_answer(Inquiry.ZOOM, ZOOM_BYTES, number),)

    def _insist_on_answer(self, inquiry: Inquiry, length: int, decode: Callable[[bytes], T]) -> T:
        """Return the answer; DeviceError if the head refuses it repeatedly."""
        reply = self._line.ask(inquiry, length, decode)
        for _ in range(ATTEMPTS - 1):
            if not isinstance(reply, Failed):
                break
            self._line.pause()
            reply = self._line.ask(inquiry, length, decode)
        if isinstance(reply, Failed):
            raise DeviceError(
                f"the camera head does not report its {inquiry.name.lower()}: {_reason(reply)}"
            )
        return reply

    def _perform(
        self,
        command: Command,
        read: Callable[[], Counts],
        target: Counts,
        near: Counts,
        deadline: float,
    ) -> Counts:
        """Return the position by `read` once the head has carried the command out."""
        reason = ""
        for _ in range(ATTEMPTS):
            reply = self._line.command(command)
            if isinstance(reply, Failed):
                reason = _reason(reply)
                if reply.error is ViscaError.BUFFER_FULL:
                    self._line.clear()
                self._line.pause()
                continue
            wait = min(COMPLETION_S, deadline - self._clock.now())
            self._line.completed(reply, max(wait, 0.0))
            # Polled in any case: the pictures need the position, and only two equal answers show
            # that none was garbled on the line, for VISCA has no checksum.
            here, there = wait_until_still(read, target, near, deadline, self._clock)
            if there:
                return here
            reason = f"it stands at {here} of its counts and was sent to {target}"
        raise DeviceError(f"the camera head does not carry out its command: {reason}")


def _reason(failed: Failed) -> str:
    match failed.error:
        case ViscaError.NOT_EXECUTABLE:
            return "it cannot do that now; it is switched off or starting: start it again"
        case ViscaError.BUFFER_FULL:
            return "it has two commands under way: see whether something else controls it"
        case ViscaError.SYNTAX | ViscaError.TOO_LONG:
            return "it does not understand the command: check that it is one of its model"
        case _:
            return "the command was given up: see whether something else controls it"
