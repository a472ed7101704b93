"""The views that are kept: few enough to be searched again, and as different as can be."""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.line_front_end.faces_from_lines import Pictures
from facetlog.perception.detection.view_graph import view_motion
from facetlog.perception.stable_order import largest
from facetlog.perception.types import View

__all__ = ["KEY_VIEWS", "KeyViews"]

# Views that are kept with their pictures, as many as the paper's tour has: of the demo's table 12
# of them show six faces, all 24 nine (seed 0).
KEY_VIEWS = 24


@dataclass(eq=False, slots=True)
class KeyViews:
    """Views (of any size) and what each shows; `changes` counts those taken since the
    last search, `complete` says that none was let go."""

    views: tuple[View, ...] = ()
    looked: Pictures | None = None
    changes: int = 0
    complete: bool = True

    def add(self, view: View, looked: Pictures) -> None:
        """Takes a view; beyond KEY_VIEWS the one goes that is most like another."""
        self.views = (*self.views, view)
        self.looked = looked if self.looked is None else self.looked.extended_by(looked)
        self.changes += 1
        if len(self.views) <= KEY_VIEWS:
            return
        motion = view_motion(self.views)
        np.fill_diagonal(motion, np.inf)
        # Of the two most alike the one goes whose next neighbour is nearer.
        nearest = np.sort(motion, axis=1)
        gone = largest(-nearest[:, 0], -nearest[:, 1])
        self.complete = False
        self.changes -= gone == len(self.views) - 1
        kept = [k for k in range(len(self.views)) if k != gone]
        self.views = tuple(self.views[k] for k in kept)
        self.looked = self.looked.select(kept)
