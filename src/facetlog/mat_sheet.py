"""A mat as a page to print: PDF in exact millimetres."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from facetlog.errors import InputError, make_missing_extra_error
from facetlog.perception.reading.mat.mats import BAR_MM, DICTIONARY, Mat

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_mat_figure", "write_mat"]

MM_PER_INCH = 25.4
TICK_MM = 2.0
WORDS_PT, LINE_PT = 7.5, 0.6
# Printers leave the outermost 4 to 6 mm of a sheet white.
MARGIN_MM = 7.0


def write_mat(mat: Mat, path: Path) -> None:
    """Write the mat as a PDF of one page; raise InputError if that cannot be, or for another
    suffix.
    """
    if path.suffix.lower() != ".pdf":
        raise InputError(f"{path}: a mat is a PDF, to be printed in its true size: -o mat.pdf")
    try:
        from matplotlib import rc_context
    except ImportError as exc:
        raise make_missing_extra_error("a mat", "matplotlib", "plots") from exc
    try:
        # Type 42: words as a TrueType font, which printers keep sharp. No date: the same each time.
        with rc_context({"pdf.fonttype": 42}):
            draw_mat_figure(mat).savefig(
                path, format="pdf", metadata={"Title": f"facetlog {mat.name}", "CreationDate": None}
            )
    except OSError as exc:
        raise InputError(f"{path} cannot be written: {exc.strerror}: choose another -o") from exc


def draw_mat_figure(mat: Mat) -> "Figure":
    """Draw the page as a figure as large as the paper, whose axes count millimetres."""
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    page = Figure(figsize=(mat.width_mm / MM_PER_INCH, mat.height_mm / MM_PER_INCH))
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, mat.width_mm)
    axes.set_ylim(0.0, mat.height_mm)
    axes.axis("off")
    shapes = [[(x, y), (x + w, y), (x + w, y + h), (x, y + h)] for x, y, w, h in mat.black()]
    axes.add_collection(PolyCollection(shapes, facecolors="black", edgecolors="none"))
    _draw_bar(axes, mat)
    return page


def _draw_bar(axes: "Axes", mat: Mat) -> None:
    """Draw a bar to check the printer's scale by, and the text that names the mat."""
    left = (mat.width_mm - mat.columns * mat.square_mm) / 2
    y = MARGIN_MM + TICK_MM / 2
    ticks = left + np.arange(0.0, BAR_MM + 1.0, 10.0)
    lines = axes.plot([left, left + BAR_MM], [y, y])
    lines += axes.plot([ticks, ticks], [[y - TICK_MM / 2], [y + TICK_MM / 2]])
    for line in lines:
        line.set(color="black", linewidth=LINE_PT, solid_capstyle="butt")
    first, last = mat.markers[0], mat.markers[-1]
    words = (
        f"{BAR_MM:g} mm if printed at 100 %; facetlog {mat.name}, squares of {mat.square_mm:g} mm, "
        f"{DICTIONARY} {first}–{last}"
    )
    axes.text(left + BAR_MM + 3.0, y, words, fontsize=WORDS_PT, va="center", ha="left")
