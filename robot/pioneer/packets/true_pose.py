"""The true pose of a simulated robot, as simulators report it (SIM_STAT, packet 0x62).

Layout of AMRISim: two texts, flags, three intervals in milliseconds, then x, y, z (mm) and heading
(degrees) as 32-bit integers, then place on earth and odometry's errors, which are not read here.
"""

import math
import struct
from dataclasses import dataclass

from facetlog.robot.pioneer.packets.packet import Packet, PacketError
from facetlog.robot.pioneer.packets.reports import Report
from facetlog.robot.pose2 import Pose2

__all__ = ["TruePose"]

TEXTS = 2
BEFORE = struct.Struct("<IHHH")
POSE = struct.Struct("<iiii")
BEHIND = struct.Struct("<iiiiiii")
NO_FIX = -1


@dataclass(frozen=True, slots=True)
class TruePose:
    """The pose in the simulator's world, in metres and radians."""

    pose: Pose2

    @classmethod
    def from_packet(cls, packet: Packet) -> "TruePose":
        """What the packet says; PacketError if it ends before the pose does."""
        data, at = packet.payload, 0
        for _ in range(TEXTS):
            at = data.find(b"\0", at) + 1
            if not at:
                raise PacketError("a SIM_STAT packet without its two texts")
        at += BEFORE.size
        if len(data) < at + POSE.size:
            raise PacketError(f"a SIM_STAT packet of {len(data)} bytes ends before the pose")
        x, y, _, heading = POSE.unpack_from(data, at)
        return cls(Pose2(x / 1e3, y / 1e3, math.radians(heading)))

    def to_packet(self) -> Packet:
        """As simulators send it: whole millimetres and degrees."""
        x, y = round(self.pose.x * 1e3), round(self.pose.y * 1e3)
        heading = round(math.degrees(self.pose.heading))
        return Packet(
            Report.SIM_STAT,
            bytes(TEXTS)
            + BEFORE.pack(0, 0, 0, 0)
            + POSE.pack(x, y, 0, heading)
            + BEHIND.pack(0, 0, 0, NO_FIX, 0, 0, 0),
        )
