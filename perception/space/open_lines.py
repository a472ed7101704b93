"""Which of a thing's unseen space shows from a place: what nothing full hides.

`Space.would_show` is the same for a place far away along an axis.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.space.space import Space, State
from facetlog.perception.types import FloatArray

# Along each axis every second cell stands for its neighbours, which show from where it shows.
EVERY = 2


@dataclass(frozen=True, eq=False, slots=True)
class UnseenSpace:
    """The middles `points` (n, 3) of unseen cells of a space that stand for all of them."""

    space: Space
    points: FloatArray

    @classmethod
    def of(cls, space: Space) -> "UnseenSpace":
        """Return choose cells that stand for the unseen part of a space."""
        cells = np.argwhere(space.cells == State.UNSEEN)
        some = cells[(cells % EVERY == 0).all(axis=1)]
        chosen = some if len(some) else cells
        lattice = space.lattice
        return cls(space, ((chosen + 0.5) * lattice.cell + lattice.corner) @ lattice.axes)

    def shown_from(self, place: FloatArray) -> NDArray[np.bool_]:
        """Return which points (n,) show from a place (3,) in the scene's frame."""
        lattice = self.space.lattice
        full = np.append((self.space.cells > State.UNSEEN).ravel(), np.False_)  # last: outside
        at = lattice.local(self.points)
        ray = lattice.local(place[None]) - at
        length = np.linalg.norm(ray, axis=1)
        ray = ray / np.maximum(length, 1.0)[:, None]
        shown = np.ones(len(at), np.bool_)
        # Beyond the lattice's diagonal there is nothing of the thing.
        for step in range(1, int(np.linalg.norm(lattice.shape)) + 1):
            on = np.flatnonzero(shown & (step < length))
            shown[on[full[lattice.numbers(at[on] + step * ray[on])]]] = False
        return shown
