"""A simulated Sony camera head, an EVI-D30; time is an argument.

Commands run in two sockets, as on the real head: moves wait for one another, the zoom runs beside
them; a drive takes effect at once. Assumed, since the manuals leave it open: a move that is
interrupted by a drive is completed, not failed; switching on takes `STARTING_S` and ends straight
ahead.
"""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Final

from facetlog.robot.head.sony_models import EVI_D30, SonyModel
from facetlog.robot.head.visca import (
    BROADCAST,
    END,
    FASTEST_PAN,
    FASTEST_TILT,
    LONGEST_FRAME,
    AbsoluteMove,
    Ack,
    AddressesSet,
    AddressSet,
    Cleared,
    Command,
    Completed,
    Drive,
    Failed,
    Fixed,
    Information,
    Inquiry,
    NetworkChange,
    Power,
    Reply,
    Version,
    ViscaError,
    ViscaSyntaxError,
    ZoomTo,
    encode_nibbles,
    encode_reply,
    parse_command,
)
from facetlog.robot.simulator.device import SerialOut, Slew

ZOOM_RANGE_S = 4.0
"""From end to end of the zoom, seconds: assumed."""
HOME: Final = AbsoluteMove(0, 0, FASTEST_PAN, FASTEST_TILT)


class SonyMotion:
    """Position and motion of the head, within its limits. ValueError without known speeds."""

    def __init__(self, model: SonyModel) -> None:
        if not (model.pan_speeds_deg and model.tilt_speeds_deg):
            raise ValueError(f"the speeds of an {model.name} are not known")
        self._model = model
        self._pan = self._tilt = self._zoom = Slew.standing(0.0)

    def place(self, now: float) -> tuple[float, float]:
        """Return pan and tilt in counts."""
        return self._pan.at(now), self._tilt.at(now)

    def zoom(self, now: float) -> float:
        return self._zoom.at(now)

    def move(self, move: AbsoluteMove, now: float) -> float:
        """Turn to a place within the limits; return when it is there."""
        self._pan = self._pan.to(move.pan, self._pan_speed(move.pan_speed), now)
        self._tilt = self._tilt.to(move.tilt, self._tilt_speed(move.tilt_speed), now)
        return max(self._pan.end, self._tilt.end)

    def go_home(self, now: float) -> float:
        """Turn straight ahead; return when it is there."""
        return self.move(HOME, now)

    def drive(self, drive: Drive, now: float) -> None:
        """Go on to the limits, or stop."""
        model = self._model
        self.stop(now)
        if drive.pan:
            end = model.pan_limit * drive.pan
            self._pan = self._pan.to(end, self._pan_speed(drive.pan_speed), now)
        if drive.tilt:
            end = model.tilt_highest if drive.tilt > 0 else model.tilt_lowest
            self._tilt = self._tilt.to(end, self._tilt_speed(drive.tilt_speed), now)

    def zoom_to(self, counts: int, now: float) -> float:
        """Zoom to a position; return when it is there."""
        self._zoom = self._zoom.to(counts, self._model.zoom_highest / ZOOM_RANGE_S, now)
        return self._zoom.end

    def stop(self, now: float) -> None:
        """Stop pan and tilt where they are."""
        self._pan, self._tilt = self._pan.stopped(now), self._tilt.stopped(now)

    def stop_zoom(self, now: float) -> None:
        """Stop the zoom where it is."""
        self._zoom = self._zoom.stopped(now)

    def _pan_speed(self, step: int) -> float:
        return self._model.pan_speeds_deg[step - 1] * self._model.pan_per_degree

    def _tilt_speed(self, step: int) -> float:
        return self._model.tilt_speeds_deg[step - 1] * self._model.tilt_per_degree


SOCKETS: Final = (1, 2)
ANSWER_S = 1 / 60
"""A head looks after its line once a picture (EVI-D70 manual, page 33)."""
STARTING_S = 5.0
"""For switching on, seconds: assumed, of the order of the values in the maker's manuals."""
SONY_VENDOR = 0x0020
"""EVI-D70 manual, page 34."""
FIRMWARE = 0x0100
MOST_UNREAD = 256
"""Bytes without an end that are kept; none of them is part of a frame any more."""


class _Part(Enum):
    """Parts of the head that a command occupies; commands for one part wait for one another."""

    HEAD = "head"
    ZOOM = "zoom"
    POWER = "power"


def _part(command: Command) -> _Part:
    match command:
        case ZoomTo():
            return _Part.ZOOM
        case Power():
            return _Part.POWER
        case _:
            return _Part.HEAD


@dataclass(slots=True)
class _Running:
    """A command in a socket; `end` is None while it waits for another's motion."""

    command: Command
    end: float | None


class SonyHead:
    """A Sony head on a serial line at 9600 baud; see `device.Device`."""

    def __init__(
        self, model: SonyModel = EVI_D30, *, powered: bool = True, baud: int = 9600
    ) -> None:
        self._model, self._motion = model, SonyMotion(model)
        self._out = SerialOut(baud)
        self._frame = bytearray()
        self._on = powered
        self._ready_at = 0.0 if powered else math.inf
        self._sockets: dict[int, _Running] = {}
        if powered:
            self._out.say(encode_reply(NetworkChange()), 0.0)

    def receive(self, data: bytes, now: float) -> None:
        self._advance(now)
        for byte in data:
            self._frame.append(byte)
            if byte == END:
                frame, self._frame = bytes(self._frame), bytearray()
                self._take(frame, now)
        if len(self._frame) > MOST_UNREAD:
            del self._frame[:-LONGEST_FRAME]

    def pending(self, now: float) -> bytes:
        """Return the bytes that it has sent up to `now` at its baud rate; each once."""
        self._advance(now)
        return self._out.arrived(now)

    def angles(self, now: float) -> tuple[float, float, float]:
        """Return where it truly looks: pan (left positive), tilt (radians), zoom in its counts."""
        self._advance(now)
        pan, tilt = self._model.angles(*self._motion.place(now))
        return pan, tilt, self._motion.zoom(now)

    def _take(self, frame: bytes, now: float) -> None:
        # Only headers have their highest bit set, so the last of them begins what is whole here.
        start = max((i for i, byte in enumerate(frame[:-1]) if byte & 0x80), default=None)
        if start is None or frame[start] & 0x7F not in (1, BROADCAST):
            return
        frame = frame[start:]
        if len(frame) > LONGEST_FRAME:
            self._say(Failed(ViscaError.TOO_LONG), now)
            return
        try:
            address, command = parse_command(frame)
            self._check_range(command)
        except ViscaSyntaxError:
            if frame[0] & 0x7F != BROADCAST:
                self._say(Failed(ViscaError.SYNTAX), now)
            return
        if address == BROADCAST:
            self._broadcast(command, now)
        elif isinstance(command, Inquiry):
            self._say(self._answer(command, now), now)
        else:
            self._order(command, now)

    def _check_range(self, command: Command) -> None:
        """Raise ViscaSyntaxError for a place out of reach, as the real head answers."""
        model = self._model
        match command:
            case AbsoluteMove(pan, tilt):
                fine = abs(pan) <= model.pan_limit
                fine &= model.tilt_lowest <= tilt <= model.tilt_highest
            case ZoomTo(counts):
                fine = 0 <= counts <= model.zoom_highest
            case _:
                fine = True
        if not fine:
            raise ViscaSyntaxError(f"{command} is out of range")

    def _broadcast(self, command: Command, now: float) -> None:
        match command:
            case AddressSet():
                self._say(AddressesSet(2), now)
            case Fixed.CLEAR:
                self._clear(now)
                self._say(Cleared(), now)

    def _answer(self, inquiry: Inquiry, now: float) -> Reply:
        match inquiry:
            case Inquiry.POWER:
                return Information(bytes([2 if self._on else 3]))
            case Inquiry.VERSION:
                version = Version(SONY_VENDOR, self._model.word, FIRMWARE, len(SOCKETS))
                return Information(version.to_bytes())
        if now < self._ready_at:
            return Failed(ViscaError.NOT_EXECUTABLE)
        match inquiry:
            case Inquiry.ZOOM:
                return Information(encode_nibbles(round(self._motion.zoom(now))))
            case Inquiry.POSITION:
                place = self._motion.place(now)
                return Information(b"".join(encode_nibbles(round(counts)) for counts in place))

    def _order(self, command: Command, now: float) -> None:
        if command is Fixed.CLEAR:
            self._clear(now)
            self._say(Information(b""), now)
            return
        socket = next((free for free in SOCKETS if free not in self._sockets), None)
        if socket is None:
            self._say(Failed(ViscaError.BUFFER_FULL), now)
        elif now < self._ready_at and not isinstance(command, Power):
            self._say(Failed(ViscaError.NOT_EXECUTABLE, socket), now)
        else:
            self._say(Ack(socket), now)
            if isinstance(command, Drive):
                self._end_motions(_part(command), now)
            running = self._sockets[socket] = _Running(command, None)
            if not self._must_wait(socket):
                running.end = self._begin(command, now)
            self._advance(now)

    def _must_wait(self, socket: int) -> bool:
        part = _part(self._sockets[socket].command)
        return part is not _Part.POWER and any(
            other != socket and _part(running.command) is part
            for other, running in self._sockets.items()
        )

    def _begin(self, command: Command, now: float) -> float:
        """Set it going at `now`; when it will be done."""
        match command:
            case AbsoluteMove():
                return self._motion.move(command, now)
            case Drive():
                self._motion.drive(command, now)
            case ZoomTo(counts):
                return self._motion.zoom_to(counts, now)
            case Power(on):
                return self._switch(on, now)
            case Fixed.HOME:
                return self._motion.go_home(now)
        return now

    def _switch(self, on: bool, now: float) -> float:
        if on and not self._on:
            self._ready_at = max(self._motion.go_home(now), now + STARTING_S)
        elif not on:
            self._motion.stop(now)
            self._motion.stop_zoom(now)
            self._drop_motions()
            self._ready_at = math.inf
        self._on = on
        return self._ready_at if on and now < self._ready_at else now

    def _clear(self, now: float) -> None:
        for running in self._sockets.values():
            if running.end is not None:
                self._stop_axes(running.command, now)
        self._drop_motions()

    def _drop_motions(self) -> None:
        self._sockets = {
            socket: running
            for socket, running in self._sockets.items()
            if _part(running.command) is _Part.POWER
        }

    def _stop_axes(self, command: Command, now: float) -> None:
        match _part(command):
            case _Part.ZOOM:
                self._motion.stop_zoom(now)
            case _Part.HEAD:
                self._motion.stop(now)

    def _end_motions(self, part: _Part, now: float) -> None:
        """End the motions of a part, the one that runs and the one that waits."""
        for socket, running in sorted(self._sockets.items()):
            if _part(running.command) is part:
                del self._sockets[socket]
                self._say(Completed(socket), now)

    def _advance(self, now: float) -> None:
        """Complete what was done by `now`, in order, and start what waited for it."""
        while True:
            ended = [(r.end, s) for s, r in self._sockets.items() if r.end is not None]
            end, socket = min(ended, default=(math.inf, 0))
            if end > now:
                return
            del self._sockets[socket]
            self._say(Completed(socket), end)
            self._start_waiting(end)

    def _start_waiting(self, now: float) -> None:
        for socket, running in sorted(self._sockets.items()):
            if running.end is None and not self._must_wait(socket):
                running.end = self._begin(running.command, now)

    def _say(self, reply: Reply, now: float) -> None:
        self._out.say(encode_reply(reply), now + ANSWER_S)
