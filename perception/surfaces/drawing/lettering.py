"""Text in pictures: ASCII only, readable on any ground, and never two words in one place."""

import itertools
import unicodedata
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

ColourImage = NDArray[np.uint8]
Colour = tuple[int, int, int]  # blue, green, red

FONT = cv2.FONT_HERSHEY_SIMPLEX
# The letters of OpenCV's stroke fonts are 21 px high at scale 1.
LETTER_HEIGHT = 21.0
RIM: Colour = (0, 0, 0)
WHITE: Colour = (255, 255, 255)
PAPER: Colour = (32, 32, 32)
"""The ground of what is written, and of sheets."""
LEGEND_PX = 9.0  # letters of a legend, for a picture 640 px on its long side
SPELLED_OUT = {"±": "+/-", "°": " deg", "×": "x", "²": "2", "–": "-", "—": "-", "…": "..."}


def plain(text: str) -> str:
    """Return the text in printable ASCII, for the stroke fonts know nothing else.

    >>> plain("90° ± 0.4°")
    '90 deg +/- 0.4 deg'
    """
    for sign, words in SPELLED_OUT.items():
        text = text.replace(sign, words)
    text = unicodedata.normalize("NFKD", text).encode("ascii", "replace").decode("ascii")
    return "".join(c if c.isprintable() else "?" for c in text)


def measure_text(text: str, height: float) -> tuple[int, int]:
    """Return the width and height in px of the text with letters of the given height in px."""
    (width, tall), below = cv2.getTextSize(
        text, FONT, height / LETTER_HEIGHT, _compute_stroke(height)
    )
    return width, tall + below


class Lettering:
    """Writes words into one picture and keeps them apart; earlier words have the better place."""

    def __init__(self, image: ColourImage) -> None:
        self._image = image
        self._taken: list[tuple[float, float, float, float]] = []

    def place(
        self,
        text: str,
        spots: tuple[tuple[float, float], ...],
        height: float,
        colour: Colour,
    ) -> bool:
        """Write the text centred at the first of the spots (u, v) where it is free; else not."""
        text = plain(text)
        width, tall = measure_text(text, height)
        for u, v in spots:
            box = (u - width / 2, v - tall / 2, u + width / 2, v + tall / 2)
            if self._free(box):
                self._taken.append(box)
                write(self._image, text, (box[0], v + height / 2), height, colour)
                return True
        return False

    def _free(self, box: tuple[float, float, float, float]) -> bool:
        h, w = self._image.shape[:2]
        left, top, right, bottom = box
        if left < 0 or top < 0 or right > w or bottom > h:
            return False
        return all(
            right <= x0 or left >= x1 or bottom <= y0 or top >= y1 for x0, y0, x1, y1 in self._taken
        )


def wrap(text: str, height: float, width: float) -> list[str]:
    """Return the text in rows of at most `width` px where its words allow; letters `height` px
    high.
    """
    rows: list[str] = []
    for word in text.split():
        longer = f"{rows[-1]} {word}" if rows else word
        if rows and measure_text(longer, height)[0] <= width:
            rows[-1] = longer
        else:
            rows.append(word)
    return rows


def write(
    image: ColourImage,
    text: str,
    start: tuple[float, float],
    height: float,
    colour: Colour,
    rim: Colour | None = RIM,
) -> None:
    """Write ASCII text, with a rim if any; `start` is the left end of the base line, px."""
    at = round(start[0]), round(start[1])
    scale, stroke = height / LETTER_HEIGHT, _compute_stroke(height)
    if rim is not None:
        # The text again, shifted: a bolder text is wider, its letters would not fit.
        for u, v in itertools.product((-stroke, 0, stroke), repeat=2):
            cv2.putText(image, text, (at[0] + u, at[1] + v), FONT, scale, rim, stroke, cv2.LINE_AA)
    cv2.putText(image, text, at, FONT, scale, colour, stroke, cv2.LINE_AA)


def _compute_stroke(height: float) -> int:
    return max(1, round(height / 10))


def add_legend(image: ColourImage, lines: Sequence[str], scale: float) -> ColourImage:
    """Return the picture (H, W, 3) with lines below it, wrapped, in letters `scale` times as
    large.
    """
    width = image.shape[1]
    height = LEGEND_PX * scale
    wrapped = [row for line in lines for row in wrap(plain(line), height, width - 2 * height)]
    strip = np.full((round(height * (1.9 * len(wrapped) + 1.2)), width, 3), PAPER, dtype=np.uint8)
    for row, line in enumerate(wrapped):
        write(strip, line, (height, height * (1.9 * row + 1.9)), height, WHITE)
    return np.vstack([image, strip])
