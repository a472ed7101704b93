"""A line to a simulated head, in time that passes only when somebody waits."""

from collections.abc import Callable

from facetlog.errors import DeviceTimeout
from facetlog.robot.head.head import Clock
from facetlog.robot.simulator.device import Device

BYTE_S = 10 / 9600
STEP_S = 0.001


class Silence:
    """A device that never says anything."""

    def receive(self, _data: bytes, _now: float, /) -> None:
        pass

    def pending(self, _now: float, /) -> bytes:
        return b""

    def angles(self, _now: float, /) -> tuple[float, float, float]:
        return 0.0, 0.0, 0.0


class SimulatedLine:
    """As the tunnel through the robot: n bytes come once n are there, what is not asked for stays.

    `spoil` changes what the device says on its way, and `spoil_sent` what it is told; each byte in
    and out waits for the robot's `cycle`. `asked` are the lengths asked for after each command.
    """

    spoil_sent: Callable[[bytes], bytes]

    def __init__(self, device: Device | Silence, spoil: Callable[[bytes], bytes] = bytes) -> None:
        self.device, self.spoil, self.spoil_sent = device, spoil, bytes
        self.cycle = 0.0
        self.now = 100.0
        self.sent: list[bytes] = []
        self.asked: list[list[int]] = []
        self.closed = False
        self._came_in = bytearray()

    @property
    def clock(self) -> Clock:
        return Clock(lambda: self.now, self.sleep)

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0
        self.now += seconds

    def flush(self) -> None:
        self.device.pending(self.now)
        self._came_in.clear()

    def send(self, data: bytes) -> None:
        self.sent.append(data)
        self.asked.append([])
        self.now += len(data) * BYTE_S + self.cycle
        self.device.receive(self.spoil_sent(data), self.now)

    def receive(self, count: int, timeout: float) -> bytes:
        self.asked[-1].append(count)
        deadline = self.now + timeout
        self.now += self.cycle
        while True:
            self._came_in += self.spoil(self.device.pending(self.now))
            if len(self._came_in) >= count:
                taken = bytes(self._came_in[:count])
                del self._came_in[:count]
                return taken
            if self.now >= deadline:
                raise DeviceTimeout(f"{len(self._came_in)} of {count} bytes came")
            self.now = min(self.now + STEP_S, deadline)

    def close(self) -> None:
        self.closed = True
