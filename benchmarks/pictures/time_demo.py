"""How much time and memory does the demo take from 24 pictures to verdict, on one core?
And a set of 16 pictures of furniture?

The pictures are rendered to files first. Each run is a process of its own, held to one core, that
reads the files, reconstructs and recognises; CPU time is what counts, as others may use the
machine. Wanted: 1.6 s in all. The furniture is a third-party set under FACETLOG_DATA, by the front
end for things in general, wanted in 3.8 s; without the data it is left out.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from time import process_time

from benchmarks.common import (
    Cell,
    Report,
    Row,
    Settings,
    Table,
    compute_median_and_spread,
    find_data_set,
)
from facetlog.perception.step_clock import StepClock, StepTime
from facetlog.pipeline import FrontEnd

NAME = "time_demo"
RUNS = 7
SEED = 0
WANTED_S, WANTED_FURNITURE_S = 1.6, 3.8
# A table on planks, whose joints make many 3-D segments.
FURNITURE = "10"
STATUS = Path("/proc/self/status")  # Linux; elsewhere the peak memory is left out


@dataclass(frozen=True, slots=True)
class TimedRun:
    """One run in a process of its own.

    `loading` is the CPU time (s) to start Python and load the libraries; `steps` came after it;
    `models` hold; `peak_mb` is the most memory that was in use, None where that is not known.
    """

    loading: float
    steps: tuple[StepTime, ...]
    models: tuple[str, ...]
    peak_mb: float | None


def measure(settings: Settings) -> Report:
    """Measure both front ends; the number of runs is that of seeds asked for."""
    count = settings.number(RUNS)
    busy = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _render(folder)
        runs = {f: [_timed_alone(folder, f) for _ in range(count)] for f in FrontEnd}
    return Report(
        NAME,
        (
            *(Table(f"Front end: {f.value}; CPU seconds", _steps(r)) for f, r in runs.items()),
            Table("Runs", tuple(_whole(f, r) for f, r in runs.items())),
            *_time_furniture(count),
        ),
        {"runs": count, "views": 24, "seed": SEED, "load before": round(busy, 2)},
        (
            f"Wanted: {WANTED_S:g} s from pictures to verdict, {WANTED_FURNITURE_S:g} s of "
            "furniture. Starting Python and loading the "
            "program come before that; rendering is not counted.",
        ),
    )


def _time_furniture(count: int) -> tuple[Table, ...]:
    folder = find_data_set("pictures")
    if isinstance(folder, str):
        return ()
    runs = [_timed_alone(folder / FURNITURE, FrontEnd.LINES) for _ in range(count)]
    return (Table(f"Furniture, set {FURNITURE}; CPU seconds", _steps(runs)),)


def _render(folder: Path) -> None:
    code = (
        "import sys; from pathlib import Path; "
        "from facetlog.robot.rendering.views import simulate; "
        "from facetlog.robot.tour import tour_camera, tour_poses; "
        "from facetlog.robot.rendering.worlds import make_world; seed = int(sys.argv[2]); "
        "simulate(Path(sys.argv[1]), make_world('block', seed), tour_poses(), tour_camera(), "
        "seed=seed)"
    )
    subprocess.run([sys.executable, "-c", code, str(folder), str(SEED)], check=True)


def _timed_alone(folder: Path, front_end: FrontEnd) -> TimedRun:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        return process.submit(run_timed, folder, front_end).result()


def run_timed(folder: Path, front_end: FrontEnd) -> TimedRun:
    """Return a run in this process, which is held to one core from here on."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    import cv2

    from facetlog.pipeline import Method, read_views_from, recognize_views

    cv2.setNumThreads(1)
    loading = process_time()  # all that this process has done so far
    clock = StepClock()
    view_set = read_views_from(folder, unit=None, progress=None, clock=clock)
    found = recognize_views(view_set, method=Method(front_end), clock=clock)
    models = tuple(sorted(found.recognition.models))
    return TimedRun(loading, clock.times, models, _peak_memory_mb())


def _peak_memory_mb() -> float | None:
    if not STATUS.exists():
        return None
    fields = dict(line.split(":", 1) for line in STATUS.read_text(encoding="ascii").splitlines())
    return float(fields["VmHWM"].split()[0]) / 1024.0


def _steps(runs: Sequence[TimedRun]) -> tuple[Row, ...]:
    names = [step.name for step in runs[0].steps]
    times = {name: [r.steps[i].cpu for r in runs] for i, name in enumerate(names)}
    totals = [sum(step.cpu for step in r.steps) for r in runs]
    times = {"load program": [r.loading for r in runs], **times, "pictures to verdict": totals}
    return tuple(
        {"step": name, **compute_median_and_spread(values)} for name, values in times.items()
    )


def _whole(front_end: FrontEnd, runs: Sequence[TimedRun]) -> dict[str, Cell]:
    peaks = [r.peak_mb for r in runs if r.peak_mb is not None]
    walls = [sum(step.wall for step in r.steps) for r in runs]
    return {
        "front end": front_end.value,
        "verdicts": ", ".join(sorted({" + ".join(r.models) or "nothing" for r in runs})),
        **{f"wall s {key}": value for key, value in compute_median_and_spread(walls).items()},
        "peak memory MB": round(max(peaks)) if peaks else None,
    }
