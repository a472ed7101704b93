"""Views into a scene: a front end finds and tracks the faces, the filters give their geometry."""

from collections.abc import Callable, Sequence

from facetlog.perception.assemble import assemble
from facetlog.perception.block_front_end.front_end import block_front_end
from facetlog.perception.line_front_end.front_end import line_front_end
from facetlog.perception.line_front_end.viewing import view_graph
from facetlog.perception.step_clock import StepClock
from facetlog.perception.tracked_faces import TrackedFace, TrackedFaces
from facetlog.perception.types import FloatArray, Scene, View

__all__ = ["reconstruct"]


def reconstruct(
    views: Sequence[View],
    *,
    name: str,
    up: FloatArray | None = None,
    metric: bool = False,
    front_end: str = "lines",
    progress: Callable[[str, int, int], None] | None = None,
    clock: StepClock | None = None,
) -> Scene:
    """The scene that the views show; InconsistentViewsError if their poses contradict them.

    `front_end` is "lines" for things in general, or "paper" for one bright block on a darker
    ground. `up` and `metric` are what is known of the world frame.
    """
    clock = clock or StepClock()
    find = {"lines": line_front_end, "paper": _paper_front_end}[front_end]
    tracked = find(views, up, clock, progress)
    with clock.step("vertices and planes"):
        return assemble(tracked, views, name=name, up=up, metric=metric)


def _paper_front_end(
    views: Sequence[View],
    up: FloatArray | None,
    clock: StepClock,
    progress: Callable[[str, int, int], None] | None,
) -> TrackedFaces:
    def report(done: int, total: int) -> None:
        if progress is not None:
            progress("features", done, total)

    with clock.step("features and tracks"):
        block = block_front_end(tuple(views), up=up, progress=report)
    weight = view_graph(views).weight
    return TrackedFaces(
        block.tracks,
        tuple(TrackedFace(outline) for outline in block.outlines),
        tuple(map(float, weight)),
        warnings=block.warnings,
    )
