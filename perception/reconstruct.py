"""Views into a scene: a front end finds and tracks the faces, the filters give their geometry."""

from collections.abc import Callable, Sequence

from facetlog.perception.assemble import assemble
from facetlog.perception.step_clock import StepClock
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
    from facetlog.perception.line_front_end.front_end import line_front_end

    tracked = line_front_end(views, clock=clock, progress=progress)
    with clock.step("vertices and planes"):
        return assemble(tracked, views, name=name, up=up, metric=metric)
