"""What a simulated robot without a clock reports of its motion."""

from facetlog.robot.pioneer.packets.reports import ServerInformation, SonarReading
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pose2 import Pose2, wrapped

MOTORS_ON = 1


def make_motion_report(
    kind: Parameters,
    counted: Pose2,
    speed: float,
    turning: float,
    sonar: tuple[SonarReading, ...] = (),
) -> ServerInformation:
    """Return the report of a robot that counted itself to a pose (m, rad) at a speed (m/s,
    rad/s).
    """
    difference = turning / kind.turning_per_speed
    return ServerInformation(
        x=round(counted.x / kind.distance) % (1 << kind.position_bits),
        y=round(counted.y / kind.distance) % (1 << kind.position_bits),
        heading=round(wrapped(counted.heading) / kind.angle),
        left=round((speed - difference) / kind.speed),
        right=round((speed + difference) / kind.speed),
        battery=120,
        stall_left=False,
        stall_right=False,
        rear_bumpers=0,
        front_bumpers=0,
        control=0,
        flags=MOTORS_ON,
        compass=0,
        sonar=sonar,
    )
