"""How far may a robot's odometry drift on its tour, and is the block recognised all the same?

The demo's tour. From view to view the robot's heading goes wrong by a normal error, its place by
2 % of the way. Poses are taken as they are, or corrected by the pictures; errors of poses are what
is left after the best common motion of all of them.
"""

from collections import defaultdict
from dataclasses import replace

import numpy as np

from benchmarks.common import Report, Settings, Table
from benchmarks.pictures.recognition import Run, counted, in_metres, recognised, tour_views
from facetlog.perception.estimation.pose_refinement.refine_poses import correct_poses
from facetlog.perception.types import PoseErrors
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.views import add_drift, pose_errors
from facetlog.robot.rendering.worlds import make_world

NAME = "accuracy_drift"
SEEDS = 3
WORLDS = ("block", "printed_block", "clutter_block", "table")
TURNS_DEG = (0.3, 0.6, 1.5)
WAY_SD = 0.02
DRIFT_STREAM = 5  # apart from the world's own draws and the pictures' noise


def measure(settings: Settings) -> Report:
    """Measure all worlds, drifts and seeds."""
    seeds = settings.seeds(SEEDS)
    rows = []
    for name in WORLDS:
        for turn_deg in TURNS_DEG:
            runs: dict[str, list[Run]] = defaultdict(list)
            errors: dict[str, list[tuple[float, float]]] = defaultdict(list)
            for seed in seeds:
                true = in_metres(name, tour_views(make_world(name, seed), seed))
                rng = np.random.default_rng([seed, 0, DRIFT_STREAM])
                views, covs = add_drift(
                    true.views, rng, turn_sd=float(np.radians(turn_deg)), way_sd=WAY_SD
                )
                given = replace(
                    true, views=views, pose_errors=PoseErrors(tuple(v.pose for v in views), covs)
                )
                for way, view_set in (("given", given), ("corrected", correct_poses(given))):
                    errors[way].append(pose_errors(view_set.views, true.views))
                    runs[way].append(recognised(view_set, FrontEnd.LINES))
            row: dict[str, str | float] = {"world": name, "degrees a step": turn_deg}
            for way in ("given", "corrected"):
                place, turn = np.median(errors[way], axis=0)
                row[f"{way}: off by cm"] = round(100 * float(place), 2)
                row[f"{way}: degrees"] = round(float(np.degrees(turn)), 2)
                row[f"{way}: answered"] = counted(run.outcome for run in runs[way])
            rows.append(row)
    return Report(
        NAME,
        (Table("Poses as given and corrected; medians", tuple(rows)),),
        {"seeds": len(seeds), "first seed": seeds.start},
    )
