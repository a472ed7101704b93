"""The driver of a Sony EVI-D30 or D31, and of its kin EVI-D70 and EVI-D100, over VISCA.

Absolute moves only, one at a time: rounding errors of relative ones add up (EVI-D100 manual, page
45). A move ends with the head's completion message or, where that is lost, with two equal reports
of its position.
"""

import math
from collections.abc import Callable
from typing import TypeVar

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.head import HeadLimits, HeadState
from facetlog.robot.head.settling import Clock, Counts, wait_until_still
from facetlog.robot.head.sony_models import EVI_D30, SONY_MODELS, SonyModel
from facetlog.robot.head.visca import (
    AbsoluteMove,
    Command,
    Drive,
    Inquiry,
    Power,
    ZoomTo,
    number,
)
from facetlog.robot.head.visca_line import ViscaLine
from facetlog.robot.head.visca_replies import (
    POSITION_BYTES,
    POWER_BYTES,
    VERSION_BYTES,
    ZOOM_BYTES,
    Failed,
    Version,
    ViscaError,
    position_of,
)

__all__ = ["SonyEviD30"]

T = TypeVar("T")

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


class SonyEviD30:
    """A Sony head on a line; `zoom` is set at the start and kept (counts, 0 the widest)."""

    def __init__(
        self, line: ByteLine, *, zoom: int = 0, address: int = 1, clock: Clock | None = None
    ) -> None:
        self._clock = clock or Clock()
        self._line = ViscaLine(line, self._clock, address)
        self._model: SonyModel = EVI_D30
        self._zoom = zoom

    @property
    def model(self) -> SonyModel:
        """The head's model; an EVI-D30 until `start` has inquired."""
        return self._model

    @property
    def limits(self) -> HeadLimits:
        """How far it can turn."""
        return self._model.limits

    def start(self) -> None:
        """Switches it on if it is off, inquires its model and sets the zoom.

        DeviceTimeout if it does not answer or does not get ready, DeviceError if the model's scale
        of angles is not known.
        """
        self._line.set_addresses()
        self._line.clear()
        self._switch_on(self._clock.now() + STARTING_S)
        self._model = self._ask_model()
        self.limits.check(0.0, 0.0, self._zoom)
        self._zoom_to(self._zoom, self._clock.now() + ZOOM_S)

    def look(
        self, pan: float, tilt: float, zoom: int | None = None, timeout: float = 10.0
    ) -> HeadState:
        """Where it stands after a move to `pan` and `tilt` (radians); returns when it is still.

        InputError beyond its limits; DeviceTimeout if it does not answer, or still moves after
        `timeout` seconds; DeviceError if it refuses or comes to stand elsewhere.
        """
        self.limits.check(pan, tilt, zoom)
        deadline = self._clock.now() + timeout
        if zoom is not None:
            self._zoom_to(zoom, deadline)
        goal_pan, goal_tilt = self._model.counts(pan, tilt)
        goal_pan = max(-self._model.pan_limit, min(goal_pan, self._model.pan_limit))
        goal_tilt = max(self._model.tilt_lowest, min(goal_tilt, self._model.tilt_highest))
        near = (
            math.ceil(NEAR_DEG * self._model.pan_per_degree),
            math.ceil(NEAR_DEG * self._model.tilt_per_degree),
        )
        move = AbsoluteMove(goal_pan, goal_tilt)
        here_pan, here_tilt = self._carry_out(
            move, self._position, (goal_pan, goal_tilt), near, deadline
        )
        return self._state(here_pan, here_tilt)

    def where(self) -> HeadState:
        """Where it looks now, moving or not; errors as `look`."""
        pan, tilt = self._position()
        (self._zoom,) = self._zoom_counts()
        return self._state(pan, tilt)

    def stop(self) -> None:
        """Stops its motion where it is; errors as `look`."""
        if isinstance(self._line.command(Drive(0, 0)), Failed):
            self._line.clear()

    def close(self) -> None:
        """Closes the line; the head stays as it stands."""
        self._line.close()

    def _state(self, pan: int, tilt: int) -> HeadState:
        return HeadState(*self._model.angles(pan, tilt), self._zoom, self._clock.now())

    def _switch_on(self, deadline: float) -> None:
        """Waits until it reports its position, which it does not while it is off or starting."""
        while True:
            power = self._line.ask(Inquiry.POWER, POWER_BYTES, bytes)
            if power in (ON, Failed(ViscaError.SYNTAX)):  # without stand-by there is nothing to ask
                position = self._line.ask(Inquiry.POSITION, POSITION_BYTES, position_of)
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
        version = self._inquired(Inquiry.VERSION, VERSION_BYTES, Version.of)
        model = SONY_MODELS.get(version.model)
        if model is None:
            known = ", ".join(f"{model.name} ({word:04X})" for word, model in SONY_MODELS.items())
            raise DeviceError(
                f"the camera head is of model {version.model:04X}, whose counts to a degree are not"
                f" known here: use one of {known}, or switch it to its D30/D31 mode"
            )
        return model

    def _position(self) -> Counts:
        return self._inquired(Inquiry.POSITION, POSITION_BYTES, position_of)

    def _zoom_counts(self) -> Counts:
        return (self._inquired(Inquiry.ZOOM, ZOOM_BYTES, number),)

    def _inquired(self, inquiry: Inquiry, length: int, decode: Callable[[bytes], T]) -> T:
        """The answer; DeviceError if the head refuses it repeatedly."""
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

    def _zoom_to(self, counts: int, deadline: float) -> None:
        (self._zoom,) = self._carry_out(
            ZoomTo(counts), self._zoom_counts, (counts,), (NEAR_ZOOM,), deadline
        )

    def _carry_out(
        self,
        command: Command,
        read: Callable[[], Counts],
        target: Counts,
        near: Counts,
        deadline: float,
    ) -> Counts:
        """The position by `read` once the head has carried the command out."""
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
