"""The motors of a simulated Sony head: pan, tilt and zoom, in its own counts."""

from typing import Final

from facetlog.robot.head.sony_models import SonyModel
from facetlog.robot.head.visca import (
    FASTEST_PAN,
    FASTEST_TILT,
    AbsoluteMove,
    Drive,
    RelativeMove,
    ZoomDrive,
)
from facetlog.robot.simulator.heads.slew import Slew

__all__ = ["SonyMotion"]

ZOOM_RANGE_S = 4.0
"""From end to end of the zoom, seconds: assumed."""
ZOOM_SPEEDS: Final = 8
HOME: Final = AbsoluteMove(0, 0, FASTEST_PAN, FASTEST_TILT)


class SonyMotion:
    """Position and motion of the head, within its limits. ValueError without known speeds."""

    def __init__(self, model: SonyModel) -> None:
        if not (model.pan_speeds_deg and model.tilt_speeds_deg):
            raise ValueError(f"the speeds of an {model.name} are not known")
        self._model = model
        self._pan = self._tilt = self._zoom = Slew.standing(0.0)

    def place(self, now: float) -> tuple[float, float]:
        """Pan and tilt in counts."""
        return self._pan.at(now), self._tilt.at(now)

    def zoom(self, now: float) -> float:
        """In counts."""
        return self._zoom.at(now)

    def move(self, move: AbsoluteMove | RelativeMove, now: float) -> float:
        """When it will be there; a relative move beyond a limit ends at the limit."""
        model = self._model
        pan, tilt = move.pan, move.tilt
        if isinstance(move, RelativeMove):
            pan, tilt = pan + round(self._pan.at(now)), tilt + round(self._tilt.at(now))
        pan = max(-model.pan_limit, min(pan, model.pan_limit))
        tilt = max(model.tilt_lowest, min(tilt, model.tilt_highest))
        self._pan = self._pan.to(pan, self._pan_speed(move.pan_speed), now)
        self._tilt = self._tilt.to(tilt, self._tilt_speed(move.tilt_speed), now)
        return max(self._pan.end, self._tilt.end)

    def go_home(self, now: float) -> float:
        """When it will look straight ahead."""
        return self.move(HOME, now)

    def drive(self, drive: Drive, now: float) -> None:
        """Goes on to the limits, or stops."""
        model = self._model
        self.stop(now)
        if drive.pan:
            end = model.pan_limit * drive.pan
            self._pan = self._pan.to(end, self._pan_speed(drive.pan_speed), now)
        if drive.tilt:
            end = model.tilt_highest if drive.tilt > 0 else model.tilt_lowest
            self._tilt = self._tilt.to(end, self._tilt_speed(drive.tilt_speed), now)

    def zoom_to(self, counts: int, now: float) -> float:
        """When the zoom will be there."""
        self._zoom = self._zoom.to(counts, self._zoom_speed(), now)
        return self._zoom.end

    def drive_zoom(self, drive: ZoomDrive, now: float) -> None:
        """Zooms on to an end, or stops."""
        self.stop_zoom(now)
        if drive.direction:
            speed = ZOOM_SPEEDS - 1 if drive.speed is None else drive.speed
            share = (speed + 1) / ZOOM_SPEEDS
            end = self._model.zoom_highest if drive.direction > 0 else 0
            self._zoom = self._zoom.to(end, self._zoom_speed() * share, now)

    def stop(self, now: float) -> None:
        """Pan and tilt stand where they are."""
        self._pan, self._tilt = self._pan.stopped(now), self._tilt.stopped(now)

    def stop_zoom(self, now: float) -> None:
        """The zoom stays as it is."""
        self._zoom = self._zoom.stopped(now)

    def _pan_speed(self, step: int) -> float:
        return self._model.pan_speeds_deg[step - 1] * self._model.pan_per_degree

    def _tilt_speed(self, step: int) -> float:
        return self._model.tilt_speeds_deg[step - 1] * self._model.tilt_per_degree

    def _zoom_speed(self) -> float:
        return self._model.zoom_highest / ZOOM_RANGE_S
