"""Fields of the simulated robot's reports, in the units of the protocol."""

import math
import struct

from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Encoders, Report
from facetlog.robot.pioneer.packets.server_information import TAIL
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.simulator.body.dynamics import Body, MotionErrors, Truth
from facetlog.robot.simulator.firmware.servo import Odometry

__all__ = ["encoders", "flags", "motion_fields", "tail", "true_pose_packet"]

MOTORS_ON, FRONT_SONAR, REAR_SONAR, STOP_BUTTON = 1 << 0, 1 << 1, 1 << 2, 1 << 5
"""Bits of the flags (Pioneer 3 manual, table 8)."""
LARGEST_I16 = 0x7FFF
HAS_ODOMETRY_ERROR = 1 << 2
ERROR_UNIT = 1e-7
NO_TEMPERATURE = -127


def motion_fields(
    parameters: Parameters, body: Body, odometry: Odometry, commanded: float | None, bits: int
) -> dict[str, int]:
    """Place, heading, wheels' speeds and the commanded heading, as a SIP has them.

    The place wraps around after so many `bits`; without a commanded heading the present one is
    used.
    """
    mask = (1 << bits) - 1
    half = body.turning * body.track / 2
    aimed = odometry.heading if commanded is None else math.remainder(commanded, 2 * math.pi)
    return {
        "x": round(odometry.x / parameters.distance) & mask,
        "y": round(odometry.y / parameters.distance) & mask,
        "heading": _i16(odometry.heading / parameters.angle),
        "left": _i16((body.speed - half) / parameters.speed),
        "right": _i16((body.speed + half) / parameters.speed),
        "control": _i16(aimed / parameters.angle),
    }


def flags(*, motors: bool, sonars: int, stop_button: bool) -> int:
    """State bits of AROS and ARCOS; `sonars` is how many are switched on."""
    return (
        MOTORS_ON * motors
        | FRONT_SONAR * (sonars > 0)
        | REAR_SONAR * (sonars > 8)
        | STOP_BUTTON * stop_button
    )


def tail(count: int, *, turning: float, battery_v: float, digital_out: int) -> dict[str, int]:
    """The first `count` fields behind the sonar readings."""
    known = {
        "digital_in": 0xFF,
        "digital_out": digital_out,
        "battery_10": round(10 * battery_v),
        "turning": _i16(10 * math.degrees(turning)),
        "temperature": NO_TEMPERATURE,
    }
    return {name: known.get(name, 0) for name, _ in TAIL[:count]}


def encoders(body: Body, ticks_mm: int) -> Encoders:
    """What both wheels' encoders have counted since power-on, in 32 bits."""
    left, right = (round(1e3 * way * ticks_mm) for way in (body.left, body.right))
    return Encoders(_wrapped(left), _wrapped(right))


def true_pose_packet(truth: Truth, errors: MotionErrors, interval_ms: int) -> Packet:
    """The true pose (SIM_STAT): millimetres and whole degrees, in AMRISim's layout.

    Two empty strings, flags, three intervals in ms, x, y, z and heading, latitude, longitude and
    altitude with their uncertainty (-1: none), and the errors of odometry as shares.
    """
    th = round(math.degrees(truth.heading))
    return Packet(
        Report.SIM_STAT,
        b"\0\0"
        + struct.pack("<IHHH", HAS_ODOMETRY_ERROR, interval_ms, interval_ms, interval_ms)
        + struct.pack("<iiii", round(1e3 * truth.x), round(1e3 * truth.y), 0, th)
        + struct.pack("<iiii", 0, 0, 0, -1)
        + struct.pack("<iii", *(_error(e) for e in (errors.left, errors.right, errors.track))),
    )


def _error(share: float) -> int:
    return round(share / ERROR_UNIT)


def _i16(value: float) -> int:
    return max(-LARGEST_I16, min(LARGEST_I16, round(value)))


def _wrapped(count: int) -> int:
    return (count + (1 << 31)) % (1 << 32) - (1 << 31)
