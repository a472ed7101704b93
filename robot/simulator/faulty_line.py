"""One direction of a line whose bytes may be lost, changed or late."""

from collections import deque

import numpy as np

__all__ = ["FaultyLine"]


class FaultyLine:
    """Bytes that go in come out, in their order; rates are shares in [0, 1], times in seconds."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.lost = 0.0
        """Share of bytes that do not arrive."""
        self.corrupt = 0.0
        """Share of bytes that arrive as others."""
        self.late = 0.0
        """Share of pieces that arrive `delay` later, with all that comes after them."""
        self.delay = 0.0
        self.frozen_until = 0.0
        """Until when nothing comes out."""
        self._queue: deque[tuple[float, bytes]] = deque()

    def push(self, data: bytes, now: float) -> None:
        """Takes a piece of traffic."""
        if not data:
            return
        due = now
        if self.late and self._rng.random() < self.late:
            due += self.delay
        if self._queue:
            due = max(due, self._queue[-1][0])
        self._queue.append((due, self._through(data)))

    @property
    def next_at(self) -> float | None:
        """When the next bytes are due."""
        return max(self._queue[0][0], self.frozen_until) if self._queue else None

    def pull(self, now: float) -> bytes:
        """What has arrived by `now`; each byte once."""
        found = b""
        while (due := self.next_at) is not None and due <= now:
            found += self._queue.popleft()[1]
        return found

    def _through(self, data: bytes) -> bytes:
        if not (self.lost or self.corrupt):
            return data
        values = np.frombuffer(data, dtype=np.uint8)
        wrong = self._rng.random(len(values)) < self.corrupt
        # Adding 1 to 255 modulo 256 gives any other value than the true one.
        shift = self._rng.integers(1, 256, len(values), dtype=np.uint8)
        changed = np.where(wrong, values + shift, values).astype(np.uint8)
        return changed[self._rng.random(len(values)) >= self.lost].tobytes()
