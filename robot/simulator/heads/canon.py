"""A simulated Canon camera head, a VC-C4 or VC-C50i; time is an argument.

It answers each command once, accepted or not; while it moves it refuses further moves as busy, but
no second order to home while it homes: ARIA gives two within a second, and begins anew, for ever,
where the second is not accepted within two (ArVCC4.cpp). A command that comes before the last one
was answered is lost, and so is every answer where the cable leaves the CTS line low
(`answers=False`).
"""

import math
from enum import Enum
from typing import Final

from facetlog.robot.head.canon import (
    END,
    VC_C4,
    Answer,
    CanonCommand,
    CanonError,
    CanonModel,
    CanonSyntaxError,
    counts_to_angles,
    encode_angle,
    encode_hexadecimal,
    number,
    parse_command,
    parse_position,
)
from facetlog.robot.simulator.device import SerialOut, Slew

HEADER = 0xFF
LONGEST_FRAME = 32
"""More than any command has; what is longer has lost its end."""
ANSWER_S = 0.05
"""From the end of a command to its answer, seconds: assumed; 0.3 at most (ARIA, ArVCC4.h)."""
SWITCHING_S = 4.0
"""For switching on or off, seconds (ARIA, ArVCC4.h)."""
MIDDLE_S = 5.0
"""For homing, seconds (ARIA, ArVCC4.h, waits 5 for it)."""
ZOOM_RANGE_S = 3.0
"""From end to end of the zoom, seconds: assumed."""
NO_EFFECT: Final = frozenset(
    {
        CanonCommand.FOCUS,
        CanonCommand.GAIN,
        CanonCommand.FOCUS_PLACE,
        CanonCommand.INFRARED_FILTER,
        CanonCommand.DIGITAL_ZOOM,
        CanonCommand.INFRARED_LIGHT,
        CanonCommand.LAMP,
    }
)
"""Accepted and answered; they do not change the head's angles."""
PEDESTAL: Final = frozenset(
    {
        CanonCommand.DRIVE,
        CanonCommand.HOME,
        CanonCommand.INITIALIZE,
        CanonCommand.MOVE,
        CanonCommand.POSITION_REQUEST,
    }
)
"""Commands that move the head or request its position."""

DONE = Answer(CanonError.NONE)
BUSY = Answer(CanonError.BUSY)
WRONG = Answer(CanonError.PARAMETER)
MODE = Answer(CanonError.MODE)


class _Power(Enum):
    OFF = 0
    SWITCHING = 1
    ON = 2


class CanonHead:
    """A Canon head on a serial line at 9600 baud; see `device.Device`."""

    def __init__(
        self,
        model: CanonModel = VC_C4,
        *,
        powered: bool = False,
        answers: bool = True,
        baud: int = 9600,
    ) -> None:
        self._model = model
        self._answers = answers
        self._out = SerialOut(baud)
        self._frame = bytearray()
        self._deaf_until = -math.inf
        self._on = powered
        self._switched_at = -math.inf
        self._by_line = False
        self._knows_middle = powered and model.finds_its_middle
        self._initialized_at = -math.inf
        self._pan = self._tilt = self._zoom = Slew.standing(0.0)
        self._pan_speed, self._tilt_speed = model.fastest_pan, model.fastest_tilt
        self._pan_range = (-model.pan_limit, model.pan_limit)
        self._tilt_range = (model.tilt_lowest, model.tilt_highest_at_first)

    def receive(self, data: bytes, now: float) -> None:
        for byte in data:
            if byte == HEADER:
                self._frame.clear()
            self._frame.append(byte)
            if byte == END and self._frame[0] == HEADER:
                self._take(bytes(self._frame), now)
            if byte == END or len(self._frame) > LONGEST_FRAME:
                self._frame.clear()

    def pending(self, now: float) -> bytes:
        """Return the bytes that it has sent up to `now` at its baud rate; each once."""
        return self._out.arrived(now)

    def angles(self, now: float) -> tuple[float, float, float]:
        """Return where it truly looks: pan (left positive), tilt (radians), zoom in its counts."""
        pan, tilt = counts_to_angles(self._pan.at(now), self._tilt.at(now))
        return pan, tilt, self._zoom.at(now)

    def _take(self, frame: bytes, now: float) -> None:
        if now < self._deaf_until:
            return
        try:
            code, parameters = parse_command(frame)
        except CanonSyntaxError:
            # Not its number, or not a command: it does not answer.
            return
        self._deaf_until = now + ANSWER_S
        try:
            answer = self._answer(CanonCommand(code), parameters, now)
        except ValueError:
            answer = WRONG
        if self._answers:
            self._out.say(answer.to_bytes(), now + ANSWER_S)

    def _power(self, now: float) -> _Power:
        if now < self._switched_at + SWITCHING_S:
            return _Power.SWITCHING
        return _Power.ON if self._on else _Power.OFF

    def _answer(self, command: CanonCommand, parameters: bytes, now: float) -> Answer:
        """Carry out a command; ValueError for parameters that it does not take."""
        power = self._power(now)
        if power is _Power.SWITCHING:
            return BUSY
        match command:
            case CanonCommand.CONTROL:
                self._by_line = _one_of(parameters, 2) == 0
                return DONE
            case CanonCommand.POWER:
                if not (self._by_line or self._model.obeys_under_remote_control):
                    return MODE
                self._switch(_one_of(parameters, 2) == 1, now)
                return DONE
        if power is _Power.OFF or not self._by_line:
            return MODE
        if command in NO_EFFECT:
            return DONE
        if command in PEDESTAL:
            return self._pedestal(command, parameters, now)
        return self._ask_or_set(command, parameters, now)

    def _switch(self, on: bool, now: float) -> None:
        if on == self._on:
            return
        self._on, self._switched_at = on, now
        self._knows_middle = on and self._model.finds_its_middle
        if self._knows_middle:
            self._go_home(now)
        else:
            self._pan, self._tilt = self._pan.stopped(now), self._tilt.stopped(now)
        self._zoom = self._zoom.stopped(now)
        self._pan_speed, self._tilt_speed = self._model.fastest_pan, self._model.fastest_tilt
        self._tilt_range = (self._model.tilt_lowest, self._model.tilt_highest_at_first)

    def _pedestal(self, command: CanonCommand, parameters: bytes, now: float) -> Answer:
        """Carry out a command that moves the head or asks for its position."""
        finding = now < self._initialized_at + MIDDLE_S
        moving = finding or now < max(self._pan.end, self._tilt.end)
        if command is CanonCommand.POSITION_REQUEST:
            if parameters:
                return WRONG
            if finding:
                return BUSY
            if not self._knows_middle:
                return MODE
            place = (self._pan.at(now), self._tilt.at(now))
            return Answer(CanonError.NONE, b"".join(encode_angle(round(axis)) for axis in place))
        if command is CanonCommand.DRIVE:
            return self._drive(_one_of(parameters, 5), moving, finding, now)
        if command is CanonCommand.INITIALIZE and finding:
            _one_of(parameters, 2)
            return DONE
        if moving:
            return BUSY
        match command:
            case CanonCommand.INITIALIZE:
                _one_of(parameters, 2)
                self._initialized_at, self._knows_middle = now, True
                self._go_home(now)
            case _ if not self._knows_middle:
                return MODE
            case CanonCommand.HOME if not parameters:
                self._go_home(now)
            case CanonCommand.MOVE:
                pan, tilt = parse_position(parameters)
                if not (_within(pan, self._pan_range) and _within(tilt, self._tilt_range)):
                    return WRONG
                self._pan = self._pan.to(pan, self._pan_speed, now)
                self._tilt = self._tilt.to(tilt, self._tilt_speed, now)
            case _:
                return WRONG
        return DONE

    def _go_home(self, now: float) -> None:
        self._pan = self._pan.to(0, self._model.fastest_pan, now)
        self._tilt = self._tilt.to(0, self._model.fastest_tilt, now)

    def _drive(self, way: int, moving: bool, finding: bool, now: float) -> Answer:
        if way == 0:
            if not finding:
                self._pan, self._tilt = self._pan.stopped(now), self._tilt.stopped(now)
            return DONE
        if moving:
            return BUSY
        if not self._knows_middle:
            return MODE
        if way <= 2:
            self._pan = self._pan.to(self._pan_range[way == 1], self._pan_speed, now)
        else:
            self._tilt = self._tilt.to(self._tilt_range[way == 3], self._tilt_speed, now)
        return DONE

    def _ask_or_set(self, command: CanonCommand, parameters: bytes, now: float) -> Answer:
        model = self._model
        zooming = now < self._zoom.end
        match command:
            case CanonCommand.PAN_SPEED:
                self._pan_speed = _digits(parameters, 3, model.slowest, model.fastest_pan)
                self._change_speed(now)
            case CanonCommand.TILT_SPEED:
                self._tilt_speed = _digits(parameters, 3, model.slowest, model.fastest_tilt)
                self._change_speed(now)
            case CanonCommand.RANGE:
                self._set_range(parameters)
            case CanonCommand.ZOOM:
                counts = _digits(parameters, 4, 0, model.zoom_highest)
                if zooming:
                    return BUSY
                self._zoom = self._zoom.to(counts, model.zoom_highest / ZOOM_RANGE_S, now)
            case CanonCommand.ZOOM_REQUEST:
                counts = model.zoom_highest if parameters == b"3" else round(self._zoom.at(now))
                if parameters not in (b"0", b"3"):
                    return WRONG
                return Answer(CanonError.NONE, encode_hexadecimal(counts, 4))
            case _:
                return WRONG
        return DONE

    def _change_speed(self, now: float) -> None:
        """Set the speed, which holds for the motion under way as well (manual, page 27)."""
        if now < self._initialized_at + MIDDLE_S:
            return
        if now < self._pan.end:
            self._pan = self._pan.to(self._pan.target, self._pan_speed, now)
        if now < self._tilt.end:
            self._tilt = self._tilt.to(self._tilt.target, self._tilt_speed, now)

    def _set_range(self, parameters: bytes) -> None:
        axis = _one_of(parameters[:1], 2)
        lowest, highest = parse_position(parameters[1:])
        model = self._model
        widest = (-model.pan_limit, model.pan_limit)
        if axis:
            widest = (model.tilt_lowest, model.tilt_highest)
        if not (_within(lowest, widest) and _within(highest, widest) and lowest <= highest):
            raise CanonSyntaxError(f"{lowest} … {highest} is no range of this head")
        if axis:
            self._tilt_range = (lowest, highest)
        else:
            self._pan_range = (lowest, highest)


def _one_of(parameters: bytes, choices: int) -> int:
    """Return a digit below `choices`; CanonSyntaxError otherwise."""
    if len(parameters) != 1 or not (choice := number(parameters)) < choices:
        raise CanonSyntaxError(f"{parameters!r} is none of the {choices} choices")
    return choice


def _digits(parameters: bytes, count: int, lowest: int, highest: int) -> int:
    if len(parameters) != count or not lowest <= (value := number(parameters)) <= highest:
        raise CanonSyntaxError(f"{parameters!r} is not within {lowest} … {highest}")
    return value


def _within(value: int, ends: tuple[int, int]) -> bool:
    return ends[0] <= value <= ends[1]
