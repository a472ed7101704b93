"""Does it ever say box where there is none, or where pictures and poses do not belong together?

Things that are no box, on the demo's tour, and the block with its poses dealt out to the wrong
pictures, which must be reported as inconsistent. Wanted: never box.
"""

import numpy as np

from benchmarks.common import Report, Row, Settings, Table, command
from benchmarks.recognition import counted, in_metres, recognised, tour_views
from facetlog.pipeline import FrontEnd
from facetlog.robot.simulate import shuffled

__all__ = ["NAME", "main", "measure"]

NAME = "accuracy_no_box"
SEEDS = 5
WORLDS = ("empty", "wedge", "pyramid", "cylinder", "corner", "table", "chair")
SHUFFLED = "block, poses shuffled"
SHUFFLE_STREAM = 2  # apart from the world's own draws and the pictures' noise


def measure(settings: Settings) -> Report:
    """Both front ends over worlds and seeds."""
    outcomes: dict[tuple[str, FrontEnd], list[str]] = {}
    faces: dict[tuple[str, FrontEnd], list[int]] = {}
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
                outcomes.setdefault((name, front_end), []).append(run.outcome)
                found = 0 if run.scene is None else len(run.scene.faces)
                faces.setdefault((name, front_end), []).append(found)
    rows: list[Row] = [
        {
            "world": name,
            "front end": front_end.value,
            "box": f"{sum('box' in outcome for outcome in found)} of {len(found)}",
            "verdicts": counted(found),
            "faces": ", ".join(map(str, faces[name, front_end])),
        }
        for (name, front_end), found in outcomes.items()
    ]
    wrong = sum("box" in outcome for found in outcomes.values() for outcome in found)
    runs = sum(map(len, outcomes.values()))
    return Report(
        NAME,
        (Table("Verdicts, and the number of faces found for each seed", tuple(rows)),),
        {"seeds": settings.number(SEEDS), "first seed": settings.first, "views": 24},
        (f"Box was said in {wrong} of {runs} runs.",),
    )


main = command(NAME, __doc__, measure)

if __name__ == "__main__":
    main(None)
