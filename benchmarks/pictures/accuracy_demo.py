"""How often is the demo's block a box and nothing else, and how exact is what was reconstructed?

The paper's block, 10 x 8 x 6 in, seen on the paper's tour of 24 views at noise of 5 grey levels
and blur of 1 px; each seed has its own place, floor and light. Wanted: a box for at least 19 of 20
seeds, with vertices within .1 in (root mean square over the block).
"""

from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, compute_median_and_spread
from benchmarks.pictures.recognition import Trial, summary, tour_views, tried
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.worlds import make_world

NAME = "accuracy_demo"
SEEDS = 20
WANTED_RMS_IN = 0.1


def measure(settings: Settings) -> Report:
    """Measure both front ends over the seeds."""
    trials: dict[FrontEnd, list[Trial]] = {front_end: [] for front_end in FrontEnd}
    seeds = settings.seeds(SEEDS)
    for seed in seeds:
        world = make_world("block", seed)
        for front_end, trial in tried(f"seed {seed}", tour_views(world, seed), world).items():
            trials[front_end].append(trial)
    good = {f: sum(map(_good, found)) for f, found in trials.items()}
    lost = [f"{f.value} {t.name}" for f, found in trials.items() for t in found if not _good(t)]
    return Report(
        NAME,
        (
            Table(
                "Verdicts, vertices and faces",
                tuple(
                    {
                        "front end": f.value,
                        **summary(found),
                        "box within .1 in": f"{good[f]} of {len(found)}",
                    }
                    for f, found in trials.items()
                ),
            ),
            Table("Errors", tuple(r for f, found in trials.items() for r in _errors(f, found))),
            Table("Covariances", tuple(_honesty(f, found) for f, found in trials.items())),
        ),
        {"seeds": len(seeds), "first seed": seeds.start, "views": 24, "noise": 5.0, "blur px": 1.0},
        (
            "A block has 8 vertices, 12 edges and 5 faces that a camera can see.",
            "NEES: squared error over its variance; 1 is an honest covariance, more is too sure.",
            f"Without a box within .1 in: {', '.join(lost) or 'none'}.",
        ),
    )


def _good(trial: Trial) -> bool:
    return trial.run.is_box and trial.score is not None and trial.score.rms <= WANTED_RMS_IN


def _errors(front_end: FrontEnd, trials: Sequence[Trial]) -> Iterable[Row]:
    scores = [t.score for t in trials if t.score is not None]
    figures = {
        "vertex, in": [e for s in scores for e in s.vertex_errors],
        "rms of a block, in": [s.rms for s in scores],
        "edge length, in": [abs(e) for s in scores for e in s.edge_errors],
        "angle of faces, deg": [abs(e) for s in scores for e in s.angle_errors],
    }
    for what, values in figures.items():
        yield {
            "front end": front_end.value,
            "error of": what,
            "count": len(values),
            **compute_median_and_spread(values, digits=4),
        }


def _honesty(front_end: FrontEnd, trials: Sequence[Trial]) -> Row:
    scores = [t.score for t in trials if t.score is not None]
    row: dict[str, str | float | None] = {"front end": front_end.value}
    for what, values in (
        ("vertices", [n for s in scores for n in s.vertex_nees]),
        ("angles", [n for s in scores for n in s.angle_nees]),
    ):
        row[f"{what} mean NEES"] = round(float(np.mean(values)), 2) if values else None
        row[f"{what} median NEES"] = round(float(np.median(values)), 2) if values else None
        row[f"{what} worst NEES"] = round(max(values), 1) if values else None
    return row
