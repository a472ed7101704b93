"""What a client may set about motion (SETV, SETA and their like), within what the robot can do."""

import math
from dataclasses import dataclass, replace

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.simulator.firmware.generations import Generation
from facetlog.robot.simulator.firmware.servo import Ramp

__all__ = ["Settings"]

BOTH_RINGS = 3
"""BUMPSTALL: 0 none, 1 the front ring, 2 the rear one, 3 both."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Limits in millimetres and degrees, as they stand on the wire."""

    speed_top: int
    turning_top: int
    acceleration_top: int
    turning_acceleration_top: int
    speed: int
    left_turning: int
    right_turning: int
    acceleration: int
    deceleration: int
    turning_acceleration: int
    turning_deceleration: int
    bump_stall: int
    e_stall: bool

    @classmethod
    def of(cls, configuration: Configuration, generation: Generation) -> "Settings":
        """Those that the robot starts with. Bumpers and stop button stall it from AROS on."""
        turning = configuration.turning_max or 0
        return cls(
            speed_top=configuration.speed_top or 0,
            turning_top=configuration.turning_top or 0,
            acceleration_top=configuration.acceleration_top or 0,
            turning_acceleration_top=configuration.turning_acceleration_top or 0,
            speed=configuration.speed_max or 0,
            left_turning=turning,
            right_turning=turning,
            acceleration=configuration.acceleration or 0,
            deceleration=configuration.deceleration or 0,
            turning_acceleration=configuration.turning_acceleration or 0,
            turning_deceleration=configuration.turning_deceleration or 0,
            bump_stall=BOTH_RINGS if generation.reports_motors else 0,
            e_stall=generation.reports_motors,
        )

    def changed(self, command: Command, value: int) -> "Settings":
        """After a command that sets something; unchanged by any other, and by a limit of zero."""
        match command:
            case Command.BUMPSTALL if 0 <= value <= BOTH_RINGS:
                return replace(self, bump_stall=value)
            case Command.E_STALL:
                return replace(self, e_stall=value != 0)
        if value == 0:
            return self
        size = abs(value)
        linear, angular = (
            min(size, self.acceleration_top),
            min(size, self.turning_acceleration_top),
        )
        match command:
            case Command.SETV:
                return replace(self, speed=min(size, self.speed_top))
            case Command.SETRV:
                turning = min(size, self.turning_top)
                return replace(self, left_turning=turning, right_turning=turning)
            case Command.SETRVDIR if value > 0:
                return replace(self, left_turning=min(size, self.turning_top))
            case Command.SETRVDIR:
                return replace(self, right_turning=min(size, self.turning_top))
            case Command.SETA if value > 0:
                return replace(self, acceleration=linear)
            case Command.SETA:
                return replace(self, deceleration=linear)
            case Command.SETRA if value > 0:
                return replace(self, turning_acceleration=angular)
            case Command.SETRA:
                return replace(self, turning_deceleration=angular)
        return self

    def ramps(self) -> tuple[Ramp, Ramp]:
        """Limits ahead in m/s and m/s², and of turning in rad/s and rad/s²."""
        ahead = (self.speed, -self.speed, self.acceleration, self.deceleration)
        turn = (
            self.left_turning,
            -self.right_turning,
            self.turning_acceleration,
            self.turning_deceleration,
        )
        return Ramp(*(mm / 1e3 for mm in ahead)), Ramp(*(math.radians(deg) for deg in turn))

    def hard_decelerations(self) -> tuple[float, float]:
        """m/s² and rad/s² of an emergency stop: as much as the robot can."""
        return self.acceleration_top / 1e3, math.radians(self.turning_acceleration_top)

    def reported(self, configuration: Configuration) -> Configuration:
        """The answer to CONFIG, with what has been set since."""
        return replace(
            configuration,
            speed_max=self.speed,
            turning_max=self.left_turning,
            acceleration=self.acceleration,
            deceleration=self.deceleration,
            turning_acceleration=self.turning_acceleration,
            turning_deceleration=self.turning_deceleration,
        )
