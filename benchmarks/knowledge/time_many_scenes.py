"""Does a batch of 100,000 scenes take flat memory, and come out the same however it is killed?

What the builders make of few faces, in random sizes, as files; of more than some hundred scenes
further names of the same files. They are classified by one worker, undisturbed, and by two, of
which, or of the run itself, at random moments something is killed (SIGKILL) and the run resumed.
Rows are compared by number and by a digest of all they hold but their seconds.
Resident memory of workers and of the run is read all along. The number of seeds asked for is that
of the scenes.
"""

import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.knowledge.time_batch import built
from facetlog.batch.journal import get_journal_path
from facetlog.batch.output import read_rows
from facetlog.perception.surfaces.scene_file import write_scene

NAME = "time_many_scenes"
SCENES = 100_000
DISTINCT = 500  # scenes that differ; more of them change neither time nor memory
LEAST_FACES, MOST_FACES = 3, 12  # it is their number that is in question
KILLS = 5
LOOKED_SECONDS = 0.05
WANTED_MB = 200
MEGABYTE = 1 << 20


@dataclass(slots=True)
class Run:
    """What was seen of a run: seconds by the clock, how often something was killed, and the most
    memory (MB) that a worker and the run itself had resident, by tenths of the rows.
    """

    seconds: float = 0.0
    killed: list[str] = field(default_factory=list)
    worker_mb: dict[int, float] = field(default_factory=dict)
    run_mb: dict[int, float] = field(default_factory=dict)


def write_scene_list(folder: Path, count: int, first: int = 0) -> Path:
    """Return a file that lists so many scenes, which are written into the folder."""
    distinct = built(min(count, DISTINCT), first, least=LEAST_FACES, most=MOST_FACES)
    paths = []
    for number in range(count):
        path = folder / f"scene{number:06}.json"
        if number < len(distinct):
            write_scene(distinct[number], path)
        else:
            path.hardlink_to(paths[number % len(distinct)])
        paths.append(path)
    listed = folder / "list.txt"
    listed.write_text("".join(f"{path}\n" for path in paths), encoding="utf-8")
    return listed


def classified(
    listed: Path, output: Path, workers: int, count: int, *, kills: int = 0, seed: int = 0
) -> Run:
    """Run classify to its end; something of it is killed `kills` times, and it is
    resumed.
    """
    generator = np.random.default_rng(seed)
    due = sorted(generator.integers(1, max(2, count - 1), kills).tolist())
    journal, run, start = get_journal_path(output), Run(), time.perf_counter()
    process = _started(listed, output, workers)
    while process.poll() is None:
        time.sleep(LOOKED_SECONDS)
        rows = _rows_in(journal)
        _look(process.pid, run, 10 * rows // count)
        if due and rows >= due[0]:
            # The first time the run itself, then by chance; never more often than was asked for.
            workers_now = list(_children(process.pid))
            of_run = not run.killed or not workers_now or generator.random() < 0.5
            target = process.pid if of_run else int(generator.choice(workers_now))
            with suppress(ProcessLookupError):
                os.kill(target, signal.SIGKILL)
            due.pop(0)
            run.killed.append("run" if of_run else "worker")
            if of_run:
                process.wait()
                process = _started(listed, output, workers, "--resume")
    run.seconds = time.perf_counter() - start
    if process.returncode != 0:
        raise RuntimeError(f"classify ended with {process.returncode}")
    return run


def _started(listed: Path, output: Path, workers: int, *more: str) -> subprocess.Popen[bytes]:
    options = ("--from", str(listed), "-o", str(output), "--workers", str(workers), *more)
    kept = output.with_suffix(".kept")  # of each run its own: the second must not read the first's
    return subprocess.Popen(
        [sys.executable, "-m", "facetlog", "classify", *options, "--keep", str(kept)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def _rows_in(journal: Path) -> int:
    """Return how many rows a journal has, by its size: all are much alike, and it may be long."""
    try:
        size = journal.stat().st_size
        with journal.open("rb") as file:
            head = len(file.readline())
            lengths = [len(line) for _, line in zip(range(100), file, strict=False)]
    except OSError:
        return 0
    return int((size - head) / float(np.mean(lengths))) if lengths else 0


def _children(pid: int) -> Iterator[int]:
    with suppress(OSError):
        yield from map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split())


def _look(pid: int, run: Run, tenth: int) -> None:
    sizes = [_resident(child) for child in _children(pid)]
    run.worker_mb[tenth] = max([run.worker_mb.get(tenth, 0.0), *sizes])
    run.run_mb[tenth] = max(run.run_mb.get(tenth, 0.0), _resident(pid))


def _resident(pid: int) -> float:
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError):  # it has ended
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / MEGABYTE


def digest(output: Path) -> tuple[int, str]:
    """Return how many rows a table has, and a digest of them but for the seconds that they took."""
    total, count = hashlib.sha256(), 0
    for row in read_rows(output):
        told = {key: value for key, value in row.items() if key != "seconds"}
        total.update(json.dumps(told).encode())
        count += 1
    return count, total.hexdigest()[:16]


def measure(settings: Settings) -> Report:
    """Measure both runs."""
    count = settings.number(SCENES)
    rows: list[Row] = []
    memory: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        listed = write_scene_list(folder, count, settings.first)
        for workers, kills in ((1, 0), (2, KILLS)):
            output = folder / f"{workers}-{kills}.jsonl"
            run = classified(listed, output, workers, count, kills=kills, seed=settings.first)
            found, told = digest(output)
            row: Row = {
                "workers": workers,
                "killed": ", ".join(run.killed) or None,
                "rows": found,
                "digest": told,
                "seconds": round(run.seconds, 1),
                "scenes a second": round(count / run.seconds, 1),
            }
            rows.append(row)
            memory.extend(_memory(workers, kills, run))
    same = len({(row["rows"], row["digest"]) for row in rows}) == 1
    return Report(
        NAME,
        (Table("Runs", tuple(rows)), Table("Resident memory, the most in a tenth", tuple(memory))),
        {"scenes": count, "distinct": min(count, DISTINCT), "kills": KILLS},
        (
            f"Both runs have the same rows: {'yes' if same else 'NO'}.",
            f"Wanted: the same rows, and a worker's memory flat and at most {WANTED_MB} MB.",
        ),
    )


def _memory(workers: int, kills: int, run: Run) -> Iterator[Row]:
    told: Sequence[tuple[str, dict[int, float]]] = (
        ("a worker", run.worker_mb),
        ("the run", run.run_mb),
    )
    for what, sizes in told:
        tenths = [sizes[k] for k in sorted(sizes) if k < 10]
        yield {
            "of": what,
            "workers": workers,
            "kills": kills,
            "MB in the first": round(tenths[0]),
            "MB at half": round(tenths[len(tenths) // 2]),
            "MB in the last": round(tenths[-1]),
        }
