"""The paper's figures 12 and 13 from a run: estimate and covariance against the number of views."""

import numpy as np

from facetlog.paper.experiment import Experiment, VertexRun
from facetlog.paper.pictures import new_figure, svg_uri

__all__ = ["covariance_curve", "estimate_curve", "shown_vertices"]

AXES = "xyz"


def shown_vertices(run: Experiment) -> tuple[VertexRun, ...]:
    """The vertex of the most views, and that of the fewest."""
    by_views = sorted(run.vertices, key=lambda v: (-len(v.views), v.label))
    return (by_views[0], by_views[-1])


def estimate_curve(vertex: VertexRun) -> str:
    """Figure 12: x, y and z less the truth after each view, with three standard deviations, and
    the printed recursion's from its zero start beside it.
    """
    figure = new_figure(6.8, 4.4)
    panels = figure.subplots(3, 1, sharex=True)
    views = np.arange(1, len(vertex.views) + 1)
    for k, axes in enumerate(panels):
        off = vertex.points[:, k] - vertex.true[k]
        sd = np.sqrt(vertex.covs[:, k, k])
        axes.fill_between(views, off - 3 * sd, off + 3 * sd, color="C0", alpha=0.2, lw=0)
        axes.plot(views, off, ".-", color="C0", label="this recursion, ± 3 sd")
        plain = vertex.plain_points[:, k] - vertex.true[k]
        axes.plot(views, plain, "--", color="C1", lw=1, label="as printed, from zero")
        axes.axhline(vertex.at_once[k] - vertex.true[k], color="C2", lw=1, label="all at once")
        # The zero start is inches off at first: what the views settle on is to be seen.
        reach = 1.1 * float(np.nanmax(np.abs(off) + 3 * sd))
        axes.set(ylim=(-reach, reach), ylabel=f"{AXES[k]} – true, in")
        axes.grid(alpha=0.3)
    panels[0].legend(frameon=False, fontsize=8, ncol=3, loc="upper right")
    panels[-1].set_xlabel("views that showed it")
    return svg_uri(figure)


def covariance_curve(vertex: VertexRun) -> str:
    """Figure 13: the elements on the covariance's diagonal after each view."""
    figure = new_figure(6.8, 2.8)
    axes = figure.subplots()
    views = np.arange(1, len(vertex.views) + 1)
    for k in range(3):
        name = f"S {AXES[k]}{AXES[k]}"
        axes.semilogy(views, vertex.covs[:, k, k], ".-", color=f"C{k}", label=name)
        axes.semilogy(views, vertex.plain_covs[:, k, k], "--", color=f"C{k}", lw=1)
    axes.plot([], [], "--", color="0.4", lw=1, label="as printed, from zero")
    axes.set(xlabel="views that showed it", ylabel="variance, in²")
    axes.legend(frameon=False, fontsize=8, ncol=2)
    axes.grid(alpha=0.3)
    return svg_uri(figure)
