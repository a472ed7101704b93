"""What do many large pictures cost, and what do their pixels give?

Views of the demo's block, rendered in 640 x 480, are enlarged to 12 megapixels, given noise and
written as JPEG files; a process of its own, held to one core, reads and recognises them. Wanted:
1.5 s of CPU a view, and 1.5 GB for 200 of them.
"""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from benchmarks.pictures.time_demo import TimedRun, run_timed
from facetlog.perception.types import Pose, View
from facetlog.pipeline import FrontEnd
from facetlog.robot.recording import write_views
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import make_ring_poses, tour_camera, tour_poses

NAME = "time_large"
VIEWS = 200
SIZE = (4000, 3000)
SEED = 0
NOISE_SD = 5.0  # grey levels, as the rendered pictures have
JPEG_QUALITY = 90
HEIGHTS = (0.35, 0.7, 1.05)  # of the ring's radius
WANTED_S, WANTED_MB = 1.5, 1500.0


def measure(settings: Settings) -> Report:
    """Measure cost; the number of views is that of seeds."""
    count = settings.number(VIEWS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_large(folder, count)
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
            run = process.submit(run_timed, folder, FrontEnd.LINES).result()
    return Report(
        NAME,
        (Table(f"{count} views of {SIZE[0]} x {SIZE[1]}", (_cost(run, count),)),),
        {"views": count, "seed": SEED},
        (f"Wanted: {WANTED_S:g} s of CPU a view, {WANTED_MB:g} MB for {VIEWS} views.",),
    )


def _ring(world: World, count: int) -> tuple[Pose, ...]:
    middle = np.mean(world.truth.solids[0].vertices, axis=0)
    radius = float(np.linalg.norm(tour_poses()[0].centre - middle))
    heights = tuple(share * radius for share in HEIGHTS)
    rng = np.random.default_rng(SEED)
    return make_ring_poses(middle, radius, heights, count, jitter=0.05, rng=rng)


def _write_large(folder: Path, count: int) -> None:
    world = make_world("block", SEED)
    small = views_of(world, _ring(world, count), tour_camera(), seed=SEED)
    camera = tour_camera().resized(*SIZE)
    nothing = np.broadcast_to(np.uint8(0), SIZE[::-1])
    # The poses and the camera; the pictures follow, one at a time.
    write_views(folder, [View(v.name, nothing, camera, v.pose) for v in small])
    cv2.setRNGSeed(SEED)
    noise = np.empty(SIZE[::-1], dtype=np.int16)
    for view in small:
        image = cv2.resize(view.image, SIZE, interpolation=cv2.INTER_CUBIC)
        noisy = np.clip(image + cv2.randn(noise, 0, NOISE_SD), 0, 255).astype(np.uint8)
        _, data = cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        (folder / view.name).write_bytes(data.tobytes())


def _cost(run: TimedRun, count: int) -> Row:
    seconds = {step.name: step.cpu for step in run.steps}
    verdict = seconds.pop("facts") + seconds.pop("verdicts")
    read = seconds["read pictures"]
    return {
        "verdict": " + ".join(run.models) or "nothing",
        "read CPU s/view": round(read / count, 3),
        "to faces CPU s/view": round((sum(seconds.values()) - read) / count, 3),
        "verdict CPU s": round(verdict, 2),
        "peak memory MB": None if run.peak_mb is None else round(run.peak_mb),
    }
