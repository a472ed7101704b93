"""The simulated firmware: commands in, motion and reports out; without I/O, time is an argument."""

import struct
from dataclasses import dataclass, field

from facetlog.robot.pioneer.packets.commands import Command, argument_of
from facetlog.robot.pioneer.packets.packet import Decoder, Packet, PacketError
from facetlog.robot.pioneer.packets.reports import InputsOutputs, Names, Report
from facetlog.robot.pioneer.packets.server_information import MOVING, STOPPED, ServerInformation
from facetlog.robot.simulator.body.dynamics import STEP
from facetlog.robot.simulator.body.sonar import Sonars
from facetlog.robot.simulator.firmware.aux_port import (
    BAUD_RATES,
    REQUESTING,
    SENDING,
    SPEEDS,
    AuxPort,
    aux_ports,
)
from facetlog.robot.simulator.firmware.drive import Drive
from facetlog.robot.simulator.firmware.generations import Generation, generation_of, tail_length
from facetlog.robot.simulator.firmware.handshake import Handshake
from facetlog.robot.simulator.firmware.report_fields import (
    encoders,
    flags,
    motion_fields,
    tail,
    true_pose_packet,
)

__all__ = ["BOOT_SECONDS", "Firmware"]

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
ANALOG_INPUTS = 8
STREAMED = (Command.SIM_STAT, Command.ENCODER, Command.IOREQUEST)
_OWN = frozenset(
    {
        *SENDING,
        *REQUESTING,
        *SPEEDS,
        *STREAMED,
        Command.POLLING,
        Command.SONAR,
        Command.DIGOUT,
        Command.HOSTBAUD,
    }
)
"""Commands that are not of motion."""


@dataclass(slots=True)
class Firmware:
    """A robot as its serial line shows it.

    `now` are seconds that begin with 0 and never run backwards; motion goes on in steps of
    `dynamics.STEP`, and a command takes effect with the next one.
    """

    drive: Drive
    sonars: Sonars
    position_bits: int = 15
    """After how many bits the odometry of a SIP rolls over."""
    ports: tuple[AuxPort, AuxPort, AuxPort] = field(default_factory=aux_ports)
    battery_v: float = FULL_BATTERY_V
    baud: int = field(default=BAUD_RATES[0], init=False)
    """Of the line to the client, if it is a serial one."""
    opened: bool = field(default=False, init=False)
    """Whether a session is open: reports are sent, and commands obeyed."""
    _generation: Generation = field(init=False)
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
    _streams: set[Command] = field(default_factory=set, init=False)
    _digital_out: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        configuration = self.drive.configuration
        self._generation = generation_of(self.drive.parameters.name)
        names = Names(configuration.name or "", configuration.robot_class, configuration.subclass)
        self._handshake = Handshake(names)
        self._start()

    def receive(self, data: bytes, now: float) -> None:
        """Takes bytes that came in at `now`; what is no whole and valid packet is ignored."""
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
        """The bytes that the robot has sent up to `now`; each once."""
        self.advance(now)
        said = bytes(self._out)
        self._out.clear()
        return said

    def advance(self, now: float) -> None:
        """Advances the robot to `now`."""
        while (at := (self._steps + 1) * STEP) <= now + STEP / 1e3:
            self._steps += 1
            self._step(at)

    def power_cycle(self, now: float, seconds: float = BOOT_SECONDS) -> None:
        """Off and on again: silent for so long, then a reset packet; all settings are lost."""
        self.advance(now)
        self._start()
        self._boot_until = now + seconds

    def _start(self) -> None:
        self.drive.reset()
        self._decoder, self._waiting_since = Decoder(), None
        self._out.clear()
        self.baud, self._baud_trial = self._flash_baud(), None
        self._digital_out = 0
        self._close()
        for port in self.ports:
            port.reset()

    def _flash_baud(self) -> int:
        return BAUD_RATES[self.drive.configuration.host_baud or 0]

    def _cycle(self) -> float:
        return (self.drive.configuration.cycle_ms or 0) / 1e3

    def _close(self) -> None:
        self.opened = False
        self._handshake.reset()
        self._streams.clear()
        self.drive.enable(False)
        self.sonars.on = False
        for port in self.ports:
            port.request(0)

    def _step(self, now: float) -> None:
        if self._boot_until is not None and now >= self._boot_until:
            self._boot_until = None
            self.drive.reset()  # whatever the wheels rolled while it was off was not counted
            self._say(Packet(Report.RESET_2))
        self._give_up_bytes(now)
        if self._baud_trial is not None and now > self._baud_trial:
            self.baud, self._baud_trial = self._flash_baud(), None
        self.drive.step(now, held=self.unattended(now))
        for port in self.ports:
            packet = port.poll(now)
            if packet is not None and self.opened:
                self._say(packet)
        if self.opened and now >= self._next_sip - STEP / 2:
            self._next_sip += self._cycle()
            self._report(now)

    def unattended(self, now: float) -> bool:
        """Whether the watchdog holds the robot, which resumes with the next packet of any kind."""
        watchdog = (self.drive.configuration.watchdog_ms or 0) / 1e3
        return self.opened and 0 < watchdog < now - self._heard

    def _say(self, packet: Packet) -> None:
        self._out += packet.to_bytes()

    # --- reports

    def _report(self, now: float) -> None:
        self._say(self._sip(now))
        for command in STREAMED:
            if command in self._streams:
                self._say(self._streamed(command))

    def _sip(self, now: float) -> Packet:
        drive, body = self.drive, self.drive.body
        front, rear = drive.bumpers()
        sonars = len(drive.parameters.sonars) if self.sonars.on else 0
        state = flags(motors=drive.motors, sonars=sonars, stop_button=drive.stop_button)
        report = ServerInformation(
            battery=min(round(10 * self.battery_v), 0xFF),
            stall_left=drive.contacts.stalled,
            stall_right=drive.contacts.stalled,
            front_bumpers=front,
            rear_bumpers=rear,
            # Before AROS a servo's pulse width stands here: no servo, no pulse.
            flags=state if self._generation.reports_motors else 0,
            compass=0,
            sonar=self.sonars.readings(now, body.truth),
            **motion_fields(
                drive.parameters, body, drive.odometry, drive.servo.heading, self.position_bits
            ),
            **tail(
                tail_length(self._generation),
                turning=body.turning,
                battery_v=self.battery_v,
                digital_out=self._digital_out,
            ),
        )
        return report.to_packet(STOPPED if body.standing else MOVING)

    # --- commands

    def _give_up_bytes(self, now: float) -> None:
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
        except (PacketError, ValueError, struct.error):
            return  # an unknown command, or one whose argument is malformed: ignored

    def _obey(self, command: Command, packet: Packet, now: float) -> None:
        if command is Command.CLOSE:
            self._close()
        elif command is Command.RESET:
            self.power_cycle(now)
        elif command is Command.CONFIG:
            self._say(self.drive.settings.reported(self.drive.configuration).to_packet())
        elif command in _OWN:
            argument = argument_of(packet)
            if isinstance(argument, int):
                self._obey_number(command, argument, now)
            elif argument is not None:
                self._obey_text(command, argument, now)
        else:
            self.drive.obey(command, packet)

    def _obey_text(self, command: Command, text: bytes, now: float) -> None:
        if command in SENDING:
            self.ports[SENDING[command]].send(text, now)
        elif command is Command.POLLING:
            self.sonars.set_order(text)

    def _obey_number(self, command: Command, value: int, now: float) -> None:
        if command in REQUESTING:
            self.ports[REQUESTING[command]].request(abs(value))
        elif command in SPEEDS:
            self.ports[SPEEDS[command]].set_baud(value)
        elif command in STREAMED:
            self._stream(command, value)
        elif command is Command.SONAR:
            self.sonars.switch(value & 1 > 0, now)
        elif command is Command.DIGOUT:  # high byte: which outputs, low byte: what they become
            mask = value >> 8 & 0xFF
            self._digital_out = self._digital_out & ~mask | value & mask
        elif command is Command.HOSTBAUD and 0 <= value < len(BAUD_RATES):
            self.baud, self._baud_trial = BAUD_RATES[value], now + BAUD_TRIAL

    def _stream(self, command: Command, value: int) -> None:
        """0: no longer, 1: once, more: with every SIP."""
        self._streams.discard(command)
        if value == 1:
            self._say(self._streamed(command))
        elif value > 1:
            self._streams.add(command)

    def _streamed(self, command: Command) -> Packet:
        body, cycle_ms = self.drive.body, round(1e3 * self._cycle())
        if command is Command.SIM_STAT:
            return true_pose_packet(body.truth, body.errors, cycle_ms)
        if command is Command.ENCODER:
            return encoders(body, self.drive.configuration.ticks_mm or 0).to_packet()
        outputs = bytes([self._digital_out])
        return InputsOutputs(b"\xff", outputs, (0,) * ANALOG_INPUTS).to_packet()
