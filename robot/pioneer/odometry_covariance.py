"""How sure a pose is that wheels have counted: what a robot's slip and errors make of its way.

Most errors of odometry are systematic: the wheels are larger than assumed, or of unequal size, the
track is wider. Such errors do not average out, so they are carried as unknown constants of the
robot with their influence on the pose (a Jacobian), beside noise that grows with the distance
(Borenstein and Feng, "Measurement and correction of systematic odometry errors in mobile robots",
1996, for the distinction; the equations are first-order propagation).
"""

import math
from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.pose2 import Pose2, wrapped

__all__ = ["OdometryCovariance", "OdometryErrors"]


@dataclass(frozen=True, slots=True)
class OdometryErrors:
    """Standard deviations of the errors of a robot's odometry.

    The first three are of constants of one robot. Their defaults are those of a robot that was
    calibrated by its maker and not by its user: 1 % of the way, 2 % of turning, and a drift whose
    double makes 30 cm in 5 m, the worst that users report of such robots.
    """

    way: float = 0.01
    """Share of the distance."""
    turning: float = 0.02
    """Share of the angle turned."""
    drift: float = 0.012
    """Radians turned unseen in each metre: half of 2 × 0.3 m / (5 m)²."""
    way_noise: float = 0.003
    """Metres after one metre, growing with the root of the distance (assumed: floor, slip)."""
    turning_noise: float = 0.01
    """Radians after one radian turned, growing with the root of it (assumed)."""
    drift_noise: float = 0.009
    """Radians after one metre, growing with the root of the distance: 2 mm of slip of each wheel in
    a metre (assumed), 0.36 m apart."""


class OdometryCovariance:
    """The covariance (3, 3) of x, y, heading in the frame in which the way began."""

    def __init__(self, errors: OdometryErrors | None = None) -> None:
        self._errors = errors or OdometryErrors()
        self._noise: FloatArray = np.zeros((3, 3))
        self._influence: FloatArray = np.zeros((3, 3))
        """Derivatives (3, 3) of x, y and heading by the errors of distance, turning and drift."""

    @property
    def covariance(self) -> FloatArray:
        """At the end of the way so far: m² and rad²."""
        e = self._errors
        constants = np.diag([e.way**2, e.turning**2, e.drift**2])
        # P = J C Jᵀ + N
        total: FloatArray = self._influence @ constants @ self._influence.T + self._noise
        return (total + total.T) / 2

    def move(self, before: Pose2, after: Pose2) -> None:
        """Takes a small motion, as the wheels counted it."""
        dx, dy = after.x - before.x, after.y - before.y
        turned = wrapped(after.heading - before.heading)
        way = math.hypot(dx, dy)
        # Of the small motion that its errors act on: along the mean heading, forward or backward.
        middle = before.heading + turned / 2
        ahead = dx * math.cos(middle) + dy * math.sin(middle)
        # F = ∂(pose after) / ∂(pose before): a heading that is off swings the step round.
        F = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
        # ∂(pose after) / ∂(way, turning, drift); a turn during the step swings half of it.
        swing = np.array([-dy / 2, dx / 2, 1.0])
        G = np.column_stack([[dx, dy, 0.0], swing * turned, swing * ahead])
        self._influence = F @ self._influence + G
        e = self._errors
        along = np.array([math.cos(middle), math.sin(middle), 0.0])
        heading_noise = e.turning_noise**2 * abs(turned) + e.drift_noise**2 * way
        self._noise = (
            F @ self._noise @ F.T
            + e.way_noise**2 * way * np.outer(along, along)
            + heading_noise * np.outer(swing, swing)
        )

    def lose(self, way: float, turned: float) -> None:
        """Takes that it may have gone so far (m) and turned so much (rad) uncounted."""
        self._noise = self._noise + np.diag([way**2, way**2, turned**2])
