"""How far poses are off, when all of them may be off together."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.types import View


def relative_errors(views: Sequence[View], true: Sequence[View]) -> tuple[float, float]:
    """Rms errors of place and turn (radians) after the best common motion of all poses."""
    ours = np.array([v.pose.centre for v in views])
    theirs = np.array([v.pose.centre for v in true])
    turns = [
        Rotation.from_matrix(t.pose.rotation @ v.pose.rotation.T)
        for v, t in zip(views, true, strict=True)
    ]
    common = Rotation.concatenate(turns).mean()
    shifted = common.apply(ours - ours.mean(axis=0)) - (theirs - theirs.mean(axis=0))
    left = (Rotation.concatenate(turns) * common.inv()).magnitude()
    return float(np.sqrt((shifted**2).sum(axis=1).mean())), float(np.sqrt((left**2).mean()))
