"""Which sides of a scene a view has in sight."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.surfaces.drawing.hidden_surface import HiddenSurface
from facetlog.perception.types import FloatArray, View

__all__ = ["in_sight"]

# Places along a side that must be seen for it to be looked for.
PLACES = 5


def in_sight(hidden: HiddenSurface, sides: FloatArray, view: View) -> NDArray[np.bool_]:
    """Which sides (n, 2, 3) no face hides from the view, (n,); `hidden` is what it sees of them."""
    share = ((np.arange(PLACES) + 0.5) / PLACES)[:, None]
    places = (sides[:, :1] + share * (sides[:, 1:] - sides[:, :1])).reshape(-1, 3)
    uv, depth = project_points(view.projection, places)
    seen = hidden.visible(np.nan_to_num(uv), depth) & (depth > 0)
    return np.asarray(seen.reshape(-1, PLACES).all(axis=1), dtype=np.bool_)
