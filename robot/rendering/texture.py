"""Seeded procedural textures: factors of the albedo of a floor or of a printed face.

A texture is a periodic bitmap of factors in (0, 1], drawn once from its seed, and sampled through a
mipmap by the footprint of the pixel, so that fine detail far away is averaged instead of aliased.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

# Texels along a side of the bitmap: one period over 512 is finer than a pixel of a usual view.
BITMAP_SIZE = 512
# cv2.remap takes maps of at most 32,767 columns or rows: long lists of samples are folded.
FOLD = 4096
TILES_A_PERIOD = 6
PLANKS_A_PERIOD = 8
PRINTED_SHAPES = 40


class Pattern(StrEnum):
    """Kinds of patterns: square tiles, wooden planks, or a printed picture."""

    TILES = "tiles"
    WOOD = "wood"
    PRINT = "print"


@dataclass(frozen=True, slots=True)
class Texture:
    """A pattern that repeats every `period` (world units); factors lie in [1 - contrast, 1]."""

    pattern: Pattern
    seed: int
    period: float
    contrast: float

    def __post_init__(self) -> None:
        if not self.period > 0:
            raise ValueError("the period of a texture must be positive")
        if not 0 <= self.contrast < 1:
            raise ValueError("the contrast of a texture must be in [0, 1)")

    def scaled(self, scale: float) -> "Texture":
        """Return the texture for a world whose lengths are `scale` times as many units."""
        return replace(self, period=scale * self.period)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A printed sheet on the floor, its middle at the origin: `print` (H, W), factors; white is 1.

    `size` is width and height (world units), the first row lies at +y. What lies round it has
    the factor `around`, times those of `texture`.
    """

    print: NDArray[np.float32]
    size: tuple[float, float]
    around: float = 1.0
    texture: Texture | None = None

    def scaled(self, scale: float) -> "Sheet":
        """Scale the print and its texture, as `Texture.scaled`."""
        width, height = self.size
        texture = self.texture and self.texture.scaled(scale)
        return replace(self, size=(scale * width, scale * height), texture=texture)

    @cached_property
    def levels(self) -> tuple[NDArray[np.float32], ...]:
        """The print, and coarser and coarser copies of half the size each."""
        levels = [np.ascontiguousarray(self.print, dtype=np.float32)]
        while min(levels[-1].shape) > 1:
            half = levels[-1].shape[1] // 2, levels[-1].shape[0] // 2
            coarser = cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA)
            levels.append(np.asarray(coarser, dtype=np.float32))
        return tuple(levels)

    def sample(self, points: FloatArray, footprint: FloatArray) -> FloatArray:
        """Return factors as `sample` below does."""
        factors = np.full(len(footprint), self.around)
        if self.texture is not None:
            factors *= sample(self.texture, points, footprint)
        x, y = points[0] / self.size[0] + 0.5, 0.5 - points[1] / self.size[1]
        on = np.flatnonzero((x >= 0) & (x <= 1) & (y >= 0) & (y <= 1))
        texels = footprint[on] * (self.print.shape[1] / self.size[0])
        level = np.clip(np.frexp(texels * np.sqrt(0.5))[1], 0, len(self.levels) - 1)
        for i in np.flatnonzero(np.bincount(level)):
            here = on[level == i]
            rows, columns = self.levels[i].shape
            factors[here] = _interpolate(
                self.levels[i], x[here] * columns - 0.5, y[here] * rows - 0.5, cv2.BORDER_REPLICATE
            )
        return factors


def sample(texture: Texture | Sheet, points: FloatArray, footprint: FloatArray) -> FloatArray:
    """Return factors (n,) at points (2, n) of the surface, each averaged over about its footprint
    (n,).

    Points and footprints are in world units.
    """
    if isinstance(texture, Sheet):
        return texture.sample(points, footprint)
    levels = _pyramid(texture.pattern, texture.seed)
    texels = footprint * (BITMAP_SIZE / texture.period)
    # The level is log2(texels), rounded; frexp's exponent of x is floor(log2(x)) + 1.
    exponent = np.frexp(texels * np.sqrt(0.5))[1]
    level = np.clip(exponent, 0, len(levels) - 1)
    turns = points / texture.period
    turns -= np.floor(turns)
    ink = np.empty(len(footprint))
    for i in np.flatnonzero(np.bincount(level)):
        here = np.flatnonzero(level == i)
        ink[here] = _read(levels[i], turns.take(here, axis=1))
    return 1.0 - texture.contrast * ink


def _read(bitmap: NDArray[np.float32], turns: FloatArray) -> FloatArray:
    # Texel j covers [j, j + 1) / size: its middle is at j + 1/2.
    x, y = turns * bitmap.shape[0] - 0.5
    return _interpolate(bitmap, x, y, cv2.BORDER_WRAP)


def _interpolate(bitmap: NDArray[np.float32], x: FloatArray, y: FloatArray, rim: int) -> FloatArray:
    """Return the bitmap at texels (n,) across and down."""
    count = len(x)
    rows = -(-count // FOLD)
    folded = np.zeros((2, rows * FOLD), dtype=np.float32)
    folded[0, :count], folded[1, :count] = x, y
    across, down = folded.reshape(2, rows, FOLD)
    out = cv2.remap(bitmap, across, down, cv2.INTER_LINEAR, borderMode=rim)
    return np.asarray(out, dtype=np.float64).reshape(-1)[:count]


@lru_cache(maxsize=32)
def _pyramid(pattern: Pattern, seed: int) -> tuple[NDArray[np.float32], ...]:
    """Return ink in [0, 1], one bitmap a level, each half the size of the one before."""
    rng = np.random.default_rng(seed)
    draw = {Pattern.TILES: _draw_tiles, Pattern.WOOD: _draw_wood, Pattern.PRINT: _print}[pattern]
    levels = [np.clip(draw(rng), 0.0, 1.0).astype(np.float32)]
    while levels[-1].shape[0] > 1:
        fine = levels[-1]
        levels.append((fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2]) / 4)
    return tuple(levels)


def _draw_blotches(rng: np.random.Generator, across: float, along: float) -> FloatArray:
    """Return periodic smooth noise with mean 0 and sd 1, (size, size); lengths of a blob in
    texels."""
    fx = np.fft.fftfreq(BITMAP_SIZE)
    low_pass = np.exp(-2 * (np.pi * along * fx[:, None]) ** 2 - 2 * (np.pi * across * fx) ** 2)
    noise = rng.normal(size=(BITMAP_SIZE, BITMAP_SIZE))
    smooth = np.fft.ifft2(np.fft.fft2(noise) * low_pass).real
    smooth -= smooth.mean()
    return np.asarray(smooth / smooth.std())


def _draw_tiles(rng: np.random.Generator) -> FloatArray:
    side = np.linspace(0, BITMAP_SIZE, TILES_A_PERIOD + 1).round().astype(int)
    ink = 0.3 + 0.12 * _draw_blotches(rng, 24, 24) + 0.05 * _draw_blotches(rng, 3, 3)
    for i in range(TILES_A_PERIOD):
        for j in range(TILES_A_PERIOD):
            ink[side[i] : side[i + 1], side[j] : side[j + 1]] += rng.normal(0, 0.06)
    for k in side[:-1]:
        ink[k : k + 3] = 0.9
        ink[:, k : k + 3] = 0.9
    return ink


def _draw_wood(rng: np.random.Generator) -> FloatArray:
    edge = np.linspace(0, BITMAP_SIZE, PLANKS_A_PERIOD + 1).round().astype(int)
    ink = 0.35 + 0.1 * _draw_blotches(rng, 2, 60) + 0.1 * _draw_blotches(rng, 20, 50)
    for left, right in pairwise(edge):
        ink[:, left:right] += rng.normal(0, 0.12)
        end = int(rng.integers(BITMAP_SIZE - 2))
        ink[end : end + 2, left:right] = 0.9
        ink[:, left : left + 2] = 0.9
    return ink


def _print(rng: np.random.Generator) -> FloatArray:
    """Return a picture of overlapping shapes and lines of lettering on a light ground."""
    sheet = np.full((BITMAP_SIZE, BITMAP_SIZE), 25, dtype=np.uint8)  # 8 bits: anti-aliased
    for _ in range(PRINTED_SHAPES):
        at = rng.integers(0, BITMAP_SIZE, 2)
        size = rng.integers(12, 110, 2)
        ink = int(rng.integers(256))
        kind = rng.integers(3)
        if kind == 0:
            corners = cv2.boxPoints((at.tolist(), size.tolist(), float(rng.uniform(0, 180))))
            cv2.fillPoly(sheet, [corners.round().astype(np.int32)], ink, cv2.LINE_AA)
        elif kind == 1:
            axes = (size // 2).tolist()
            angle = float(rng.uniform(0, 180))
            cv2.ellipse(sheet, at.tolist(), axes, angle, 0, 360, ink, -1, cv2.LINE_AA)
        else:
            where = (int(at[0]) - 40, int(at[1]))
            word = "".join(chr(c) for c in rng.integers(65, 91, 6))
            height = float(rng.uniform(0.8, 2.2))
            font = cv2.FONT_HERSHEY_SIMPLEX
            cv2.putText(sheet, word, where, font, height, ink, 4, cv2.LINE_AA)
    return sheet / 255.0
