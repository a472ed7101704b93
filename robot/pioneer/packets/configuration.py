"""The configuration packet (CONFIG): the robot's make, limits and settings, sent on request.

Speeds are in mm/s and degrees/s, accelerations in mm/s² and degrees/s², times in milliseconds, as
they stand on the wire. Old firmware sends fewer fields: those that are missing are None.
"""

import struct
from dataclasses import dataclass

from facetlog.robot.pioneer.packets.packet import Packet, PacketError

__all__ = ["AUTOBAUD", "CONFIGURATION_KIND", "SIMULATOR", "Configuration"]

CONFIGURATION_KIND = 0x20
AUTOBAUD = 2
"""Value of `autobaud` of a port that takes a change of its speed."""

SIMULATOR = "facetlog"
"""First word of the serial number of a robot that `facetlog simulate` is; its camera's address is
the second. Other simulators have "SIM"."""

STRING = "s"
LAYOUT = (
    ("robot_class", STRING),
    ("subclass", STRING),
    ("serial_number", STRING),
    ("four_motors", "B"),
    ("turning_top", "H"),
    ("speed_top", "H"),
    ("turning_acceleration_top", "H"),
    ("acceleration_top", "H"),
    ("pwm_max", "H"),
    ("name", STRING),
    ("cycle_ms", "B"),
    ("host_baud", "B"),
    ("aux1_baud", "B"),
    ("gripper", "H"),
    ("front_sonar", "H"),
    ("rear_sonar", "B"),
    ("low_battery", "H"),
    ("rev_count", "H"),
    ("watchdog_ms", "H"),
    ("normal_packets", "B"),
    ("stall_value", "H"),
    ("stall_count", "H"),
    ("joystick_speed", "H"),
    ("joystick_turning", "H"),
    ("turning_max", "H"),
    ("speed_max", "H"),
    ("turning_acceleration", "H"),
    ("turning_deceleration", "H"),
    ("rot_kp", "H"),
    ("rot_kv", "H"),
    ("rot_ki", "H"),
    ("acceleration", "H"),
    ("deceleration", "H"),
    ("trans_kp", "H"),
    ("trans_kv", "H"),
    ("trans_ki", "H"),
    ("front_bumpers", "B"),
    ("rear_bumpers", "B"),
    ("charger", "B"),
    ("sonar_cycle", "B"),
    ("autobaud", "B"),
    ("gyro", "B"),
    ("drift_factor", "h"),
    ("aux2_baud", "B"),
    ("aux3_baud", "B"),
    ("ticks_mm", "H"),
    ("shutdown_voltage", "H"),
    ("firmware", STRING),
    ("gyro_clockwise", "H"),
    ("gyro_counter_clockwise", "H"),
    ("kinematics_delay", "B"),
)


@dataclass(frozen=True, slots=True)
class Configuration:
    """The robot's make, its limits and its settings."""

    robot_class: str
    subclass: str
    serial_number: str | None = None
    four_motors: int | None = None
    turning_top: int | None = None
    """The robot never turns faster, whatever is commanded."""
    speed_top: int | None = None
    turning_acceleration_top: int | None = None
    acceleration_top: int | None = None
    pwm_max: int | None = None
    name: str | None = None
    cycle_ms: int | None = None
    """Between two reports."""
    host_baud: int | None = None
    aux1_baud: int | None = None
    gripper: int | None = None
    front_sonar: int | None = None
    rear_sonar: int | None = None
    low_battery: int | None = None
    """Tenths of a volt."""
    rev_count: int | None = None
    watchdog_ms: int | None = None
    normal_packets: int | None = None
    stall_value: int | None = None
    stall_count: int | None = None
    joystick_speed: int | None = None
    joystick_turning: int | None = None
    turning_max: int | None = None
    speed_max: int | None = None
    turning_acceleration: int | None = None
    turning_deceleration: int | None = None
    rot_kp: int | None = None
    rot_kv: int | None = None
    rot_ki: int | None = None
    acceleration: int | None = None
    deceleration: int | None = None
    trans_kp: int | None = None
    trans_kv: int | None = None
    trans_ki: int | None = None
    front_bumpers: int | None = None
    """How many there are."""
    rear_bumpers: int | None = None
    charger: int | None = None
    sonar_cycle: int | None = None
    autobaud: int | None = None
    gyro: int | None = None
    drift_factor: int | None = None
    aux2_baud: int | None = None
    aux3_baud: int | None = None
    ticks_mm: int | None = None
    shutdown_voltage: int | None = None
    firmware: str | None = None
    gyro_clockwise: int | None = None
    gyro_counter_clockwise: int | None = None
    kinematics_delay: int | None = None

    @property
    def simulated(self) -> bool:
        """Whether it is of `facetlog simulate`."""
        return (self.serial_number or "").split()[:1] == [SIMULATOR]

    @property
    def simulated_camera(self) -> str | None:
        """The address of the simulated camera; None of a real robot or another simulator."""
        words = (self.serial_number or "").split()
        return words[1] if self.simulated and len(words) > 1 else None

    @classmethod
    def from_packet(cls, packet: Packet) -> "Configuration":
        """The contents of a CONFIG packet; PacketError if not even class and subclass are in it."""
        data, at = packet.payload, 0
        found: dict[str, str | int] = {}
        for name, form in LAYOUT:
            if form == STRING:
                end = data.find(b"\0", at)
                if end < 0:
                    break
                found[name] = data[at:end].decode("latin-1")
                at = end + 1
                continue
            size = struct.calcsize("<" + form)
            if len(data) < at + size:
                break
            (found[name],) = struct.unpack_from("<" + form, data, at)
            at += size
        if "subclass" not in found:
            raise PacketError(f"a CONFIG packet without class and subclass: {data[:40].hex(' ')}")
        return cls(**found)  # type: ignore[arg-type]

    def to_packet(self) -> Packet:
        """As the robot sends it, with the fields down to the first that is None."""
        data = b""
        for name, form in LAYOUT:
            value = getattr(self, name)
            if value is None:
                break
            if form == STRING:
                data += value.encode("latin-1") + b"\0"
            else:
                data += struct.pack("<" + form, value)
        return Packet(CONFIGURATION_KIND, data)
