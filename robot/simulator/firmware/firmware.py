"""The simulated firmware: handshake, commands, reports, AUX ports; no I/O, time is an argument."""

import math
from dataclasses import dataclass, field

from facetlog.robot.pioneer.packets.commands import Command, read_argument
from facetlog.robot.pioneer.packets.packet import Decoder, Packet, PacketError
from facetlog.robot.pioneer.packets.reports import (
    MOVING,
    STOPPED,
    TAIL,
    Names,
    Report,
    ServerInformation,
    TruePose,
)
from facetlog.robot.simulator.body import STEP, Sonars
from facetlog.robot.simulator.device import Device
from facetlog.robot.simulator.firmware.drive import Drive
from facetlog.robot.simulator.firmware.factory_settings import TAIL_LENGTHS

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)
"""By the code that the AUX1BAUD and HOSTBAUD commands carry."""
BUFFER = 256
"""Bytes that a port buffers until they are requested; later ones are lost."""
LARGEST_REQUEST = 200
"""Bytes that one GETAUX can request on P2OS (Pioneer 2 manual, page 48)."""


@dataclass(slots=True)
class AuxPort:
    """One port: bytes go out to a device at once, and come in when a client requests so many."""

    report: Report
    device: Device | None = None
    device_baud: int = BAUD_RATES[0]
    baud: int = BAUD_RATES[0]
    silent: bool = False
    """Whether the device neither hears nor answers, as one without power."""
    _came: bytearray = field(default_factory=bytearray, init=False)
    _wanted: int = field(default=0, init=False)

    def send(self, data: bytes, now: float) -> None:
        """Send bytes from the client to the device, which ignores them at the wrong baud rate."""
        if self.device is not None and not self.silent and self.baud == self.device_baud:
            self.device.receive(data, now)

    def request(self, count: int) -> None:
        """GETAUX: 0 clears the buffer and the request, else so many bytes are requested."""
        if count == 0:
            self._came.clear()
        self._wanted = min(count, LARGEST_REQUEST)

    def set_baud(self, code: int) -> None:
        """Set the baud rate of an AUX port; codes that mean no speed are ignored."""
        if 0 <= code < len(BAUD_RATES):
            self.baud = BAUD_RATES[code]

    def reset(self) -> None:
        self._came.clear()
        self._wanted, self.baud = 0, BAUD_RATES[0]

    def poll(self, now: float) -> Packet | None:
        """Receive the device's bytes; return the requested report, once it is complete."""
        if self.device is not None:
            said = self.device.pending(now)
            if not self.silent and self.baud == self.device_baud:
                self._came += said[: BUFFER - len(self._came)]
        if not self._wanted or len(self._came) < self._wanted:
            return None
        packet = Packet(self.report, bytes(self._came[: self._wanted]))
        del self._came[: self._wanted]
        self._wanted = 0
        return packet


SENDING = {Command.TTY2: 0, Command.TTY3: 1, Command.TTY4: 2}
REQUESTING = {Command.GETAUX: 0, Command.GETAUX2: 1, Command.GETAUX3: 2}
SPEEDS = {Command.AUX1BAUD: 0, Command.AUX2BAUD: 1}
"""Commands by the port that they are for."""


SYNCHRONISED = 3
"""How many of SYNC0, SYNC1 and SYNC2 a client must have sent, in their order."""


@dataclass(slots=True)
class Handshake:
    """Answers packets while no session is open; OPEN after the three SYNCs opens one.

    OPEN has the number of SYNC1, CLOSE that of SYNC2 and PULSE that of SYNC0: the meaning depends
    on the packets before.
    """

    names: Names
    _next: int = field(default=0, init=False)

    def reset(self) -> None:
        """Expect SYNC0 again, as after CLOSE."""
        self._next = 0

    def heard(self, packet: Packet) -> tuple[tuple[Packet, ...], bool]:
        """Return the answer to a packet, and whether it opened a session.

        A SYNC out of order is answered with 0xFF, and the client has to start again. The previous
        one may be repeated, for its echo may have been lost. Anything else is echoed (Pioneer 2
        manual, page 41).
        """
        if self._next == SYNCHRONISED and packet.kind == Command.OPEN:
            self.reset()
            return (), True
        if packet.kind > Report.SYNC2:
            return (packet,), False
        if packet.payload:  # a SYNC has none: it is an OPEN or CLOSE that came too early
            self.reset()
            return (), False
        if packet.kind == Report.SYNC0 or packet.kind in (self._next, self._next - 1):
            self._next = packet.kind + 1
            known = packet.kind == Report.SYNC2
            return (self.names.to_packet() if known else Packet(packet.kind),), False
        self.reset()
        return (Packet(Report.RESET_2),), False


MOTORS_ON, FRONT_SONAR, REAR_SONAR, STOP_BUTTON = 1 << 0, 1 << 1, 1 << 2, 1 << 5
"""Bits of the flags (Pioneer 3 manual, table 8)."""
LARGEST_I16 = 0x7FFF
NO_TEMPERATURE = -127


def _clip_to_i16(value: float) -> int:
    return max(-LARGEST_I16, min(LARGEST_I16, round(value)))


LARGEST_COMMAND = 200
"""Count byte of a command above which it is ignored (manual of 1999, page 26)."""
BYTE_PAUSE = 0.1
"""Seconds without a byte after which a command that is not whole is given up."""
COMMAND_SECONDS = 0.3
"""Seconds that the longest command takes at 9600 baud, and half as much again."""
BAUD_TRIAL = 0.5
"""Seconds within which a valid packet must come at a new speed of the line (H8 manual, page 51)."""
BOOT_SECONDS = 1.0
FULL_BATTERY_V = 12.8
_OWN = frozenset(
    {*SENDING, *REQUESTING, *SPEEDS, Command.SIM_STAT, Command.SONAR, Command.HOSTBAUD}
)
"""Commands that are not of motion."""


@dataclass(slots=True)
class Firmware:
    """A robot as its serial line shows it.

    `now` are seconds that begin with 0 and never run backwards; motion goes on in steps of
    `body.STEP`, and a command takes effect with the next one.
    """

    drive: Drive
    sonars: Sonars
    position_bits: int = 15
    """After how many bits the odometry of a SIP rolls over."""
    ports: tuple[AuxPort, AuxPort, AuxPort] = field(
        default_factory=lambda: (
            AuxPort(Report.SERAUX),
            AuxPort(Report.SERAUX2),
            AuxPort(Report.SERAUX3),
        )
    )
    battery_v: float = FULL_BATTERY_V
    baud: int = field(default=BAUD_RATES[0], init=False)
    """Of the line to the client, if it is a serial one."""
    opened: bool = field(default=False, init=False)
    """Whether a session is open: reports are sent, and commands obeyed."""
    _handshake: Handshake = field(init=False)
    _decoder: Decoder = field(default_factory=Decoder, init=False)
    _out: bytearray = field(default_factory=bytearray, init=False)
    _steps: int = field(default=0, init=False)
    _heard: float = field(default=0.0, init=False)
    _byte_at: float = field(default=0.0, init=False)
    _waiting_since: float | None = field(default=None, init=False)
    _next_sip: float = field(default=0.0, init=False)
    _boot_until: float | None = field(default=None, init=False)
    _baud_trial: float | None = field(default=None, init=False)
    _streams_pose: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        configuration = self.drive.configuration
        names = Names(configuration.name or "", configuration.robot_class, configuration.subclass)
        self._handshake = Handshake(names)
        self._start()

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes that came in at `now`; what is no whole and valid packet is ignored."""
        self.advance(now)
        if self._boot_until is not None or not data:
            return
        self._byte_at = now
        for received in self._decoder.feed(data, now):
            self._take(received.packet, now)
        if not self._decoder.waiting:
            self._waiting_since = None
        elif self._waiting_since is None:
            self._waiting_since = now

    def pending(self, now: float) -> bytes:
        """Return the bytes that the robot has sent up to `now`; each once."""
        self.advance(now)
        said = bytes(self._out)
        self._out.clear()
        return said

    def advance(self, now: float) -> None:
        while (at := (self._steps + 1) * STEP) <= now + STEP / 1e3:
            self._steps += 1
            self._step(at)

    def power_cycle(self, now: float, seconds: float = BOOT_SECONDS) -> None:
        """Switch off and on: silent for so long, then a reset packet; all settings are lost."""
        self.advance(now)
        self._start()
        self._boot_until = now + seconds

    def _start(self) -> None:
        self.drive.reset()
        self._decoder, self._waiting_since = Decoder(), None
        self._out.clear()
        self.baud, self._baud_trial = self._find_flash_baud(), None
        self._close()
        for port in self.ports:
            port.reset()

    def _find_flash_baud(self) -> int:
        return BAUD_RATES[self.drive.configuration.host_baud or 0]

    def _cycle(self) -> float:
        return (self.drive.configuration.cycle_ms or 0) / 1e3

    def _close(self) -> None:
        self.opened = False
        self._handshake.reset()
        self._streams_pose = False
        self.drive.enable(False)
        self.sonars.on = False
        for port in self.ports:
            port.request(0)

    def _step(self, now: float) -> None:
        if self._boot_until is not None and now >= self._boot_until:
            self._boot_until = None
            self.drive.reset()  # whatever the wheels rolled while it was off was not counted
            self._say(Packet(Report.RESET_2))
        self._expire_bytes(now)
        if self._baud_trial is not None and now > self._baud_trial:
            self.baud, self._baud_trial = self._find_flash_baud(), None
        self.drive.step(now, held=self.unattended(now))
        for port in self.ports:
            packet = port.poll(now)
            if packet is not None and self.opened:
                self._say(packet)
        if self.opened and now >= self._next_sip - STEP / 2:
            self._next_sip += self._cycle()
            self._report(now)

    def unattended(self, now: float) -> bool:
        """Return whether the watchdog holds the robot, which resumes with the next packet of any
        kind.
        """
        watchdog = (self.drive.configuration.watchdog_ms or 0) / 1e3
        return self.opened and 0 < watchdog < now - self._heard

    def _say(self, packet: Packet) -> None:
        self._out += packet.to_bytes()

    # --- reports

    def _report(self, now: float) -> None:
        self._say(self._make_sip(now))
        if self._streams_pose:
            self._say(self._true_pose())

    def _make_sip(self, now: float) -> Packet:
        drive, body, odometry = self.drive, self.drive.body, self.drive.odometry
        units = drive.parameters
        front, rear = drive.bumpers()
        sonars = len(units.sonars) if self.sonars.on else 0
        mask = (1 << self.position_bits) - 1
        half = body.turning * body.track / 2
        flags = 0  # Before AROS, a servo's pulse width: no servo, no pulse.
        if units.generation.reports_motors:
            flags = (
                MOTORS_ON * drive.motors
                | FRONT_SONAR * (sonars > 0)
                | REAR_SONAR * (sonars > 8)
                | STOP_BUTTON * drive.stop_button
            )
        tail = {
            "digital_in": 0xFF,
            "battery_10": round(10 * self.battery_v),
            "turning": _clip_to_i16(10 * math.degrees(body.turning)),
            "temperature": NO_TEMPERATURE,
        }
        report = ServerInformation(
            x=round(odometry.x / units.distance) & mask,
            y=round(odometry.y / units.distance) & mask,
            heading=_clip_to_i16(odometry.heading / units.angle),
            left=_clip_to_i16((body.speed - half) / units.speed),
            right=_clip_to_i16((body.speed + half) / units.speed),
            control=_clip_to_i16(odometry.heading / units.angle),
            battery=min(round(10 * self.battery_v), 0xFF),
            stall_left=drive.contacts.stalled,
            stall_right=drive.contacts.stalled,
            front_bumpers=front,
            rear_bumpers=rear,
            flags=flags,
            compass=0,
            sonar=self.sonars.readings(now, body.truth),
            **{name: tail.get(name, 0) for name, _ in TAIL[: TAIL_LENGTHS[units.generation]]},
        )
        return report.to_packet(STOPPED if body.standing else MOVING)

    # --- commands

    def _expire_bytes(self, now: float) -> None:
        since = self._waiting_since
        if since is None:
            return
        if now - self._byte_at > BYTE_PAUSE or now - since > COMMAND_SECONDS:
            self._waiting_since = None
            for received in self._decoder.expire():
                self._take(received.packet, now)

    def _take(self, packet: Packet, now: float) -> None:
        if len(packet.payload) + 3 > LARGEST_COMMAND:
            return
        self._heard, self._baud_trial = now, None
        if not self.opened:
            answers, self.opened = self._handshake.heard(packet)
            for answer in answers:
                self._say(answer)
            if self.opened:
                self._next_sip = now + self._cycle()
                self.sonars.switch(True, now)
            return
        try:
            self._obey(Command(packet.kind), packet, now)
        except (PacketError, ValueError):
            return  # an unknown command, or one whose argument is malformed: ignored

    def _obey(self, command: Command, packet: Packet, now: float) -> None:
        if command is Command.CLOSE:
            self._close()
        elif command is Command.CONFIG:
            self._say(self.drive.settings.reported(self.drive.configuration).to_packet())
        elif command in _OWN:
            argument = read_argument(packet)
            if isinstance(argument, int):
                self._obey_number(command, argument, now)
            elif argument is not None and command in SENDING:
                self.ports[SENDING[command]].send(argument, now)
        else:
            self.drive.obey(command, packet)

    def _obey_number(self, command: Command, value: int, now: float) -> None:
        if command in REQUESTING:
            self.ports[REQUESTING[command]].request(abs(value))
        elif command in SPEEDS:
            self.ports[SPEEDS[command]].set_baud(value)
        elif command is Command.SIM_STAT:  # 0: no longer, 1: once, more: with every SIP
            self._streams_pose = value > 1
            if value == 1:
                self._say(self._true_pose())
        elif command is Command.SONAR:
            self.sonars.switch(value & 1 > 0, now)
        elif command is Command.HOSTBAUD and 0 <= value < len(BAUD_RATES):
            self.baud, self._baud_trial = BAUD_RATES[value], now + BAUD_TRIAL

    def _true_pose(self) -> Packet:
        errors = self.drive.body.errors
        shares = (errors.left, errors.right, errors.track)
        return TruePose(self.drive.body.truth).to_packet(round(1e3 * self._cycle()), shares)
