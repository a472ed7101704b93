"""Plot how degrees rose and standard deviations fell while views arrived."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import make_missing_extra_error

if TYPE_CHECKING:
    from facetlog.stream import StreamStep

__all__ = ["Degrees", "check_plots", "collect_degrees", "write_degree_plot"]

# Models with a line of their own: those with the highest degrees.
SHOWN = 6


@dataclass(frozen=True, slots=True)
class Degrees:
    """Result of a step: views `used`, the highest degree of each model that holds for
    something, and the largest standard deviation of a vertex (the scene's unit); `polished` of the
    last step.
    """

    used: int
    of_models: dict[str, float]
    largest_sd: float | None
    metric: bool
    polished: bool


def collect_degrees(step: "StreamStep") -> Degrees:
    """Return the degrees after a step."""
    best: dict[str, float] = {}
    for verdict in () if step.recognition is None else step.recognition.best:
        best[verdict.model] = max(verdict.degree, best.get(verdict.model, 0.0))
    metric = step.scene is not None and step.scene.metric
    return Degrees(step.used, best, step.largest_sd, metric, not step.view)


def check_plots() -> None:
    """Raise InputError if nothing can be plotted here: to be called before any long work."""
    if find_spec("matplotlib") is None:
        raise make_missing_extra_error("plots", "matplotlib", "plots")


def write_degree_plot(path: Path, steps: Sequence[Degrees], name: str) -> None:
    """Write an SVG: above the degree of each model that ever held, below the largest standard
    deviation; a ring after the last view is the polished result.
    """
    # Not at the top: it takes longer to load than a view.
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    top = {m: max(s.of_models.get(m, 0.0) for s in steps) for s in steps for m in s.of_models}
    models = sorted(top, key=lambda m: (-top[m], m))[:SHOWN]
    each = [s for s in steps if not s.polished]
    last = next((s for s in steps if s.polished), None)
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    FigureCanvasSVG(figure)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    views = [s.used for s in each]
    for model in models:
        (line,) = above.plot(
            views, [100.0 * s.of_models.get(model, 0.0) for s in each], ".-", label=model
        )
        if last is not None:
            degree = 100.0 * last.of_models.get(model, 0.0)
            above.plot(last.used + 0.5, degree, "o", mfc="none", color=line.get_color())
    if models:
        above.legend(loc="best", frameon=False)
    else:
        above.text(0.5, 0.5, "no model matched", ha="center", transform=above.transAxes)
    above.set(ylim=(-4.0, 104.0), ylabel="degree, %", title=f"{name}, view by view")
    known = [(s.used, s.largest_sd) for s in each if s.largest_sd]
    if known:
        below.semilogy(*zip(*known, strict=True), ".-", color="0.3")
    if last is not None and last.largest_sd:
        below.semilogy(last.used + 0.5, last.largest_sd, "o", mfc="none", color="0.3")
    unit = "m" if any(s.metric for s in steps) else "units"
    below.set(xlabel="views used (ring: polished)", ylabel=f"largest sd, {unit}")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    below.xaxis.get_major_locator().set_params(integer=True)
    # The same run gives the same file, with text as text.
    with rc_context({"svg.hashsalt": "facetlog", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
