"""Does it ever say box where there is none, or where pictures and poses do not belong together?

Things that are no box, on the demo's tour, and the block with its poses dealt out to the wrong
pictures, which must be reported as inconsistent. Wanted: never box.
"""

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.pictures.recognition import BOX, Run, counted, in_metres, recognised, tour_views
from facetlog.pipeline import FrontEnd
from facetlog.robot.rendering.views import shuffled

NAME = "accuracy_no_box"
SEEDS = 5
WORLDS = ("empty", "wedge", "pyramid", "cylinder", "corner", "table", "chair")
SHUFFLED = "block, poses shuffled"
SHUFFLE_STREAM = 2  # apart from the world's own draws and the pictures' noise


def measure(settings: Settings) -> Report:
    """Measure both front ends over worlds and seeds."""
    runs: dict[tuple[str, FrontEnd], list[Run]] = {}
    for name in (*WORLDS, SHUFFLED):
        for seed in settings.seeds(SEEDS):
            if name == SHUFFLED:
                rng = np.random.default_rng([seed, 0, SHUFFLE_STREAM])
                views = shuffled(tour_views("block", seed), rng)
            else:
                views = tour_views(name, seed)
            view_set = in_metres(f"{name}-{seed}", views)
            for front_end in FrontEnd:
                run = recognised(view_set, front_end)
                runs.setdefault((name, front_end), []).append(run)
    rows: list[Row] = [
        {
            "world": name,
            "front end": front_end.value,
            "box": f"{sum(map(_says_box, found))} of {len(found)}",
            "verdicts": counted(run.outcome for run in found),
            "faces": ", ".join("–" if r.scene is None else f"{len(r.scene.faces)}" for r in found),
        }
        for (name, front_end), found in runs.items()
    ]
    everything = [run for found in runs.values() for run in found]
    return Report(
        NAME,
        (Table("Verdicts, and the number of faces found for each seed", tuple(rows)),),
        {"seeds": settings.number(SEEDS), "first seed": settings.first, "views": 24},
        (f"Box was said in {sum(map(_says_box, everything))} of {len(everything)} runs.",),
    )


def _says_box(run: Run) -> bool:
    return BOX in run.models
