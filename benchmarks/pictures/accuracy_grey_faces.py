"""Are regions of one grey the faces that are found in 3-D, and what does region growing keep?

The tour round the demo's block, seeds in turn, by the paper's front end. Per picture the regions of
one grey (figure 9; step 6) beside the faces of the scene that all pictures make: the adjusted Rand
index over their pixels, and how many of the faces in sight have a region of their own. The 2-D
vertices at the paper's threshold and at brighter ones, by thresholding alone and with growing.
"""

import numpy as np

from benchmarks.common import Cell, Report, Settings, Table
from facetlog.paper.experiment import Experiment, run_experiment
from facetlog.perception.detection.block_front_end.faces_of_block import picture_features
from facetlog.perception.step_clock import StepClock

__all__ = ["NAME", "measure"]

NAME = "accuracy_grey_faces"
SEEDS = 10
THRESHOLDS = (150, 180, 200, 220)


def _agreement(runs: list[Experiment]) -> dict[str, Cell]:
    each = [a for run in runs for a in run.agreement]
    rand = [a.rand for a in each if a.rand is not None]
    own = [o for a in each for o in a.own]
    return {
        "pictures": len(each),
        "Rand, median": round(float(np.median(rand)), 3),
        "Rand, 10 %": round(float(np.quantile(rand, 0.1)), 3),
        "faces in sight": len(own),
        "with a region of their own": sum(own),
        "share": round(sum(own) / len(own), 3),
    }


def _vertices(runs: list[Experiment], threshold: int) -> dict[str, Cell]:
    count = [0, 0]
    for run in runs:
        for view in run.views:
            for grow in (False, True):
                found = picture_features(view.image, threshold=threshold, grow=grow)
                count[grow] += len(found.vertices)
    return {
        "threshold": threshold,
        "2-D vertices, thresholding alone": count[0],
        "and growing": count[1],
    }


def measure(settings: Settings) -> Report:
    """Agreement of regions and faces, and the vertices that growing keeps."""
    seeds = range(settings.first, settings.first + settings.number(SEEDS))
    runs = [run_experiment(seed, None, StepClock()) for seed in seeds]
    return Report(
        NAME,
        (
            Table("regions of one grey and 3-D faces", (_agreement(runs),)),
            Table("2-D vertices", tuple(_vertices(runs[:3], t) for t in THRESHOLDS)),
        ),
        {"seeds": len(seeds)},
    )
