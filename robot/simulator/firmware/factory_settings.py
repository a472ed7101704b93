"""The settings of a simulated robot as it leaves the factory, by its model and firmware."""

import math

from facetlog.robot.pioneer.packets.reports import AUTOBAUD, SIMULATOR, Configuration
from facetlog.robot.pioneer.parameters import Parameters

ROBOT_CLASS = "Pioneer"
# Fields behind the sonar readings that each generation sends (manuals of 1999, of H8 and of
# Pioneer 3): down to the digital outputs, to the state of the charger, to the faults.
TAIL_LENGTHS = (4, 4, 6, 8)
# Speeds and accelerations a maker's robot leaves the factory with, mm and degrees: what ARIA
# prints of a Pioneer 3-DX; drivers set their own.
SPEED_MAX, TURNING_MAX, ACCELERATION, TURNING_ACCELERATION = 750, 100, 300, 100
SPEED_TOP, TURNING_TOP, ACCELERATION_TOP, TURNING_ACCELERATION_TOP = 1500, 300, 2000, 600
WATCHDOG_MS = 2000  # default of all generations (Pioneer 2 manual, page 40)
CYCLE_MS = 100
BUMPERS = 5  # segments of the ring in front and of that behind
TICKS_MM = 128
FIRMWARE = ("1.0", "1.K", "2.6", "2.9")


def make_default_configuration(parameters: Parameters, name: str) -> Configuration:
    """Return the CONFIG report of this model with its default settings."""
    generation = parameters.generation
    speed_top = min(SPEED_TOP, round(1e3 * parameters.speed_top))
    turning_top = min(TURNING_TOP, round(math.degrees(parameters.turning_top)))
    sonars = len(parameters.sonars)
    return Configuration(
        robot_class=ROBOT_CLASS,
        subclass=parameters.name,
        serial_number=SIMULATOR,
        four_motors=0,
        turning_top=turning_top,
        speed_top=speed_top,
        turning_acceleration_top=TURNING_ACCELERATION_TOP,
        acceleration_top=ACCELERATION_TOP,
        pwm_max=400,
        name=name,
        cycle_ms=CYCLE_MS,
        host_baud=0,
        aux1_baud=0,
        gripper=0,
        front_sonar=int(sonars > 0),
        rear_sonar=int(sonars > 8),
        low_battery=115,
        rev_count=16570,
        watchdog_ms=WATCHDOG_MS,
        normal_packets=0,
        stall_value=200,
        stall_count=200,
        joystick_speed=min(SPEED_MAX, speed_top),
        joystick_turning=50,
        turning_max=min(TURNING_MAX, turning_top),
        speed_max=min(SPEED_MAX, speed_top),
        turning_acceleration=TURNING_ACCELERATION,
        turning_deceleration=TURNING_ACCELERATION,
        rot_kp=40,
        rot_kv=20,
        rot_ki=0,
        acceleration=ACCELERATION,
        deceleration=ACCELERATION,
        trans_kp=40,
        trans_kv=30,
        trans_ki=0,
        front_bumpers=BUMPERS,
        rear_bumpers=BUMPERS,
        charger=0,
        sonar_cycle=40,
        autobaud=AUTOBAUD if generation.reports_motors else 0,
        gyro=0,
        drift_factor=0,
        aux2_baud=0,
        aux3_baud=0,
        ticks_mm=TICKS_MM,
        shutdown_voltage=110,
        firmware=FIRMWARE[generation],
        gyro_clockwise=0,
        gyro_counter_clockwise=0,
        kinematics_delay=0,
    )
