"""The interface of a device on a serial port of the simulated robot, such as a camera head."""

from typing import Protocol

__all__ = ["Device"]


class Device(Protocol):
    """A simulated device on a serial line, in time that its caller counts (`now`, seconds).

    It has no clock and no thread: calls come with times that never run backwards.
    """

    def receive(self, data: bytes, now: float) -> None:
        """Takes bytes that came in at `now`."""

    def pending(self, now: float) -> bytes:
        """What it has said up to `now`, as fast as its baud rate lets it; each byte once."""

    def angles(self, now: float) -> tuple[float, float, float]:
        """Where it truly looks at `now`: pan (left positive), tilt (up positive), zoom.

        Radians; zero is straight ahead and level. The zoom is in the device's own counts, 0 the
        widest.
        """
