"""The serial ports inside the robot (AUX1 to AUX3), through which its client talks to devices."""

from dataclasses import dataclass, field

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Report
from facetlog.robot.simulator.device import Device

__all__ = ["BAUD_RATES", "LARGEST_REQUEST", "AuxPort", "aux_ports"]

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
        """Bytes from the client to the device, which ignores them at the wrong baud rate."""
        if self.device is not None and not self.silent and self.baud == self.device_baud:
            self.device.receive(data, now)

    def request(self, count: int) -> None:
        """GETAUX: 0 clears the buffer and the request, else so many bytes are requested."""
        if count == 0:
            self._came.clear()
        self._wanted = min(count, LARGEST_REQUEST)

    def set_baud(self, code: int) -> None:
        """AUX1BAUD and its like; codes that mean no speed are ignored."""
        if 0 <= code < len(BAUD_RATES):
            self.baud = BAUD_RATES[code]

    def reset(self) -> None:
        """As after power-on."""
        self._came.clear()
        self._wanted, self.baud = 0, BAUD_RATES[0]

    def poll(self, now: float) -> Packet | None:
        """Receives the device's bytes; returns the requested report, once it is complete."""
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


def aux_ports() -> tuple[AuxPort, AuxPort, AuxPort]:
    """The three ports, with nothing on them."""
    return AuxPort(Report.SERAUX), AuxPort(Report.SERAUX2), AuxPort(Report.SERAUX3)


SENDING = {Command.TTY2: 0, Command.TTY3: 1, Command.TTY4: 2}
REQUESTING = {Command.GETAUX: 0, Command.GETAUX2: 1, Command.GETAUX3: 2}
SPEEDS = {Command.AUX1BAUD: 0, Command.AUX2BAUD: 1}
"""Commands by the port that they are for."""
