"""How soon and how well are things recognised while views come, and what does one view cost?

The demo's block, seeds in turn, its 24 views one at a time in the order of the tour: errors of the
faces' corners and NEES / 3 against views, beside all of these views at once; of the upper corners
apart, for beside a block's foot there may be a strip of shadow narrower than the blur, which moves
the foot's edge by a tenth of a pixel in every view. Furniture of the first seeds: the first verdict
that is right. A ring of 200 views of a block gives the processor time of a view, late and early;
faces are searched anew in the kept views now and then, which is counted apart.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import (
    Cell,
    Report,
    Settings,
    Table,
    compute_median_and_spread,
)
from facetlog.perception.online.online_scene import OnlineScene
from facetlog.perception.scene import Scene
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import FloatArray, View
from facetlog.pipeline import open_models, render_simulated_views
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import INCH, make_world
from facetlog.robot.tour import make_ring_poses, tour_camera
from facetlog.stream import recognise_stream

NAME = "accuracy_online"
SEEDS = 10
FURNITURE_SEEDS = 2
# Faces are searched anew after 4, 8, 11, 15 and 20 views: most of these lie between.
SHOWN = (4, 5, 7, 8, 10, 12, 14, 16, 18, 19, 22, 24)
WORLDS = {"block": "box", "printed_block": "box", "table": "table", "chair": "chair"}
UP = np.array([0.0, 0.0, 1.0])
# A corner farther off than this is none of the block's, m.
NEAR_M = 0.02
RING_VIEWS, RING_IN = 200, 45.0


@dataclass(frozen=True, slots=True)
class _Errors:
    """Errors of corners: which of the true ones they are, squared errors, NEES, and which are above
    the floor.
    """

    which: NDArray[np.intp]
    squares: FloatArray
    nees: FloatArray
    above: NDArray[np.bool_]

    def of(self, which: set[int]) -> FloatArray:
        """Return the squared errors of some of the true corners."""
        return np.asarray(self.squares[np.isin(self.which, list(which))])


def _errors(scene: Scene | None, true: FloatArray) -> _Errors:
    """Return the errors of the faces' corners that are some corner of the block."""
    corners = sorted({k for f in scene.faces for k in f.outline}) if scene else []
    if scene is None or not corners:
        none = np.zeros(0)
        return _Errors(none.astype(np.intp), none, none, none.astype(np.bool_))
    apart = scene.points[corners][:, None] - true[None]
    which = (apart**2).sum(axis=2).argmin(axis=1)
    off = apart[np.arange(len(corners)), which]
    near = (off**2).sum(axis=1) < NEAR_M**2
    covs = np.array([scene.vertices[k].cov for k in corners])[near]
    nees = np.einsum("ni,nij,nj->n", off[near], np.linalg.inv(covs), off[near])
    squares = (off[near] ** 2).sum(axis=1)
    return _Errors(which[near], squares, nees, true[which[near], 2] > NEAR_M)


def _against_views(seeds: range) -> Iterator[dict[str, Cell]]:
    found: dict[int, list[tuple[_Errors, _Errors]]] = {k: [] for k in SHOWN}
    for seed in seeds:
        views = render_simulated_views("block", seed, progress=None, clock=StepClock()).views
        true = np.array(make_world("block", seed).truth.solids[0].vertices) * INCH
        online = OnlineScene(name="block", up=UP, metric=True)
        for count, view in enumerate(views, start=1):
            online.add(view)
            if count in SHOWN:
                batch = reconstruct(views[:count], name="block", up=UP, metric=True)
                found[count].append((_errors(online.scene, true), _errors(batch, true)))
    for count in SHOWN:
        row: dict[str, Cell] = {"views": count}
        for which, name in ((0, "one at a time"), (1, "at once")):
            squares = np.concatenate([pair[which].squares for pair in found[count]])
            nees = np.concatenate([pair[which].nees for pair in found[count]])
            row[f"corners, {name}"] = len(squares)
            row[f"rms mm, {name}"] = round(1e3 * float(np.sqrt(squares.mean())), 3)
            above = np.concatenate([pair[which].above for pair in found[count]])
            for kept, of in ((above | True, ""), (above, "above the floor, ")):
                mean = round(float(nees[kept].mean() / 3), 2) if kept.any() else None
                row[f"NEES / 3, {of}{name}"] = mean
        both = [(a, b, {*a.which.tolist()} & {*b.which.tolist()}) for a, b in found[count]]
        squares = [np.concatenate([pair[k].of(pair[2]) for pair in both]) for k in (0, 1)]
        row["rms ratio, corners of both"] = round(
            float(np.sqrt(squares[0].mean() / squares[1].mean())), 2
        )
        yield row


def _verdicts(seeds: range) -> Iterator[dict[str, Cell]]:
    with open_models() as base:
        for world, model in WORLDS.items():
            for seed in seeds[: None if world == "block" else FURNITURE_SEEDS]:
                given = render_simulated_views(world, seed, progress=None, clock=StepClock())
                stream = recognise_stream(
                    given.views, up=given.up, metric=True, base=base, polish=True
                )
                degrees = [
                    max((v.degree for v in s.recognition.best if v.model == model), default=0.0)
                    if s.recognition
                    else 0.0
                    for s in stream
                ]
                *each, last = degrees
                first = next((n for n, d in enumerate(each, start=1) if d), None)
                stays = next((n for n in range(1, 25) if all(each[n - 1 :])), None)
                yield {
                    "world": f"{world} {seed}",
                    "first right after": first,
                    "and stays so after": stays,
                    "degree after 4, 8, 12, 24 views": ", ".join(
                        f"{each[n - 1]:.2f}" for n in (4, 8, 12, 24)
                    ),
                    "polished": round(last, 2),
                }


def _ring() -> tuple[View, ...]:
    world = make_world("block", 0)
    middle = np.array(world.truth.solids[0].vertices).mean(axis=0)
    poses = make_ring_poses(middle, RING_IN, (25.0,), RING_VIEWS)
    return views_of(world, poses, tour_camera(), seed=0)


def _times() -> tuple[Table, Table]:
    online = OnlineScene(name="block", up=UP)
    plain: list[tuple[int, float]] = []
    searches: list[tuple[int, float]] = []
    for number, view in enumerate(_ring(), start=1):
        start = process_time()
        update = online.add(view)
        spent = 1e3 * (process_time() - start)
        (searches if update.searched else plain).append((number, spent))
    windows = [
        {
            "views": f"{first} to {last}",
            **_figures([ms for n, ms in plain if first <= n <= last]),
            "searches": sum(first <= n <= last for n, _ in searches),
        }
        for first, last in ((4, 20), (10, 30), (90, 110), (180, 200))
    ]
    features = next(t.cpu for t in online.clock.times if t.name == "features")
    every = [ms for _, ms in (*plain, *searches)]
    whole: dict[str, Cell] = {
        "mean ms a view, with searches": round(sum(every) / RING_VIEWS, 1),
        "of that detection": round(1e3 * features / RING_VIEWS, 1),
        "searches": len(searches),
        "longest search, ms": round(max(ms for _, ms in searches), 1),
    }
    return (
        Table("a ring of 200 views: views without a search", tuple(windows)),
        Table("all 200 views", (whole,)),
    )


def _figures(values: list[float]) -> dict[str, Cell]:
    return {f"ms a view, {k}": v for k, v in compute_median_and_spread(values, digits=1).items()}


def measure(settings: Settings) -> Report:
    """Measure errors and NEES against views, first verdicts, times."""
    seeds = range(settings.first, settings.first + settings.number(SEEDS))
    return Report(
        NAME,
        (
            Table("the block's corners against views", tuple(_against_views(seeds))),
            Table("verdicts", tuple(_verdicts(seeds))),
            *_times(),
        ),
        {"seeds": len(seeds)},
    )
