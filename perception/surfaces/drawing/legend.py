"""The strip of text below a drawn picture."""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.surfaces.drawing.lettering import Colour, ColourImage, plain, wrap, write

__all__ = ["PAPER", "with_legend"]

LETTERS_PX = 9.0  # of a picture 640 px on its long side
WHITE: Colour = (255, 255, 255)
PAPER: Colour = (32, 32, 32)
"""The ground of what is written, and of sheets."""


def with_legend(image: ColourImage, lines: Sequence[str], scale: float) -> ColourImage:
    """The picture (H, W, 3) with lines below it, wrapped, in letters `scale` times as large."""
    width = image.shape[1]
    height = LETTERS_PX * scale
    wrapped = [row for line in lines for row in wrap(plain(line), height, width - 2 * height)]
    strip = np.full((round(height * (1.9 * len(wrapped) + 1.2)), width, 3), PAPER, dtype=np.uint8)
    for row, line in enumerate(wrapped):
        write(strip, line, (height, height * (1.9 * row + 1.9)), height, WHITE)
    return np.vstack([image, strip])
