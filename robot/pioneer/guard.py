"""Stop conditions in a robot's reports, and in which direction it may still be driven."""

from facetlog.robot.pioneer.problems import Cause, Problem
from facetlog.robot.pioneer.state import RobotState

__all__ = ["Guard"]

BATTERY_TIME = 1.0
"""Seconds of low voltage: starting motors make it dip for some tenths."""
START_TIME = 1.5
"""Seconds within which a commanded robot has begun to move (it gains 0.3 m/s in one)."""
CERTAIN_SPEED, CERTAIN_TURNING = 0.03, 0.09
"""m/s and rad/s (5 degrees) below which motors may lack the torque to start at all."""
MOTORS_OFF_TEXT = "motors are off: press the MOTORS button or call enable_motors()"


class Guard:
    """Compares each report with the one before and with the commanded speeds."""

    def __init__(self, battery_v: float) -> None:
        self._battery_v = battery_v
        self._before: RobotState | None = None
        self._low_since: float | None = None
        self._battery_said = False
        self._told_since: float | None = None

    def look(
        self, state: RobotState, commanded: tuple[float, float], motors_wanted: bool
    ) -> list[Problem]:
        """The new problems in a report; `commanded` are the last speed and turning sent."""
        before, self._before = self._before, state
        found = [
            *_bumped(state, before),
            *_stalled(state, before),
            *_switched(state, before, motors_wanted),
            *self._battery(state),
            *self._idle(state, commanded),
        ]
        return [Problem(cause, text, state.at, stopped=True) for cause, text in found]

    def refusal(self, state: RobotState, speed: float) -> str | None:
        """Why the robot may not be driven so as it is now; None if it may."""
        if state.stop_button:
            return "the STOP button is pressed: pull it out, then call enable_motors()"
        if state.motors_on is False:
            return MOTORS_OFF_TEXT
        if self._low_since is not None and state.at - self._low_since >= BATTERY_TIME:
            return self._battery_text(state)
        if speed > 0 and any(state.front_bumpers):
            return "a front bumper is pressed: drive backward, or free the robot"
        if speed < 0 and any(state.rear_bumpers):
            return "a rear bumper is pressed: drive forward, or free the robot"
        return None

    def _battery_text(self, state: RobotState) -> str:
        volts = f"{state.battery_v:.1f} V, limit {self._battery_v:.1f} V"
        return f"the battery is low ({volts}): charge it"

    def _battery(self, state: RobotState) -> list[tuple[Cause, str]]:
        if not 0 < state.battery_v < self._battery_v:
            self._low_since = None
            return []
        if self._low_since is None:
            self._low_since = state.at
        if self._battery_said or state.at - self._low_since < BATTERY_TIME:
            return []
        self._battery_said = True
        return [(Cause.LOW_BATTERY, self._battery_text(state))]

    def _idle(self, state: RobotState, commanded: tuple[float, float]) -> list[tuple[Cause, str]]:
        certain = abs(commanded[0]) >= CERTAIN_SPEED or abs(commanded[1]) >= CERTAIN_TURNING
        if not certain or not state.standing or any(state.stalled):
            self._told_since = None
            return []
        if self._told_since is None:
            self._told_since = state.at
        if state.at - self._told_since < START_TIME:
            return []
        self._told_since = None
        return [
            (
                Cause.NOT_MOVING,
                f"commanded to move for {START_TIME} s, the robot stands: if its motors are off,"
                " press the MOTORS button or call enable_motors(); see that the STOP button is out",
            )
        ]


def _bumped(state: RobotState, before: RobotState | None) -> list[tuple[Cause, str]]:
    found = []
    for side, now, then in (
        ("front", state.front_bumpers, before.front_bumpers if before else ()),
        ("rear", state.rear_bumpers, before.rear_bumpers if before else ()),
    ):
        new = [i for i, pressed in enumerate(now) if pressed and not (i < len(then) and then[i])]
        if new:
            numbers = ", ".join(str(i + 1) for i in new)
            found.append((Cause.BUMPER, f"bumper pressed ({side} {numbers}): free the robot"))
    return found


def _stalled(state: RobotState, before: RobotState | None) -> list[tuple[Cause, str]]:
    if state.stop_button:
        return []  # the button shows as a stall of both wheels too (E_STALL)
    then = before.stalled if before else (False, False)
    new = [
        side
        for side, now, old in zip(("left", "right"), state.stalled, then, strict=True)
        if now and not old
    ]
    if not new:
        return []
    wheels = " and ".join(new)
    return [(Cause.STALL, f"{wheels} wheel stalled: something is in the way; free the robot")]


def _switched(
    state: RobotState, before: RobotState | None, motors_wanted: bool
) -> list[tuple[Cause, str]]:
    if state.stop_button and not (before and before.stop_button):
        return [(Cause.STOP_BUTTON, "STOP button pressed: pull it out, then call enable_motors()")]
    if state.stop_button is None:
        return []  # old firmware: the motors' state is inferred from problems already reported
    went_off = before is not None and before.motors_on and state.motors_on is False
    if went_off and motors_wanted:
        return [(Cause.MOTORS_OFF, MOTORS_OFF_TEXT)]
    return []
