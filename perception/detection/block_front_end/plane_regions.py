"""The face regions of one picture: segmentation by several thresholds (step 6 of the algorithm).

Step 6: "segmenting them further into different regions using average intensity of
8-neighbourhood points of a pixel as a measure". Section 5.3: the histogram "has multiple peaks";
"a threshold marginally exceeding the gray value corresponding to the peak" parts each plane off.
"""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import FloatArray, Image

# A peak of the histogram rises above the valleys beside it by this share of its own height;
# smoothing at the noise of the averages leaves far less of a chance ripple.
PEAK_PROMINENCE = 0.15
# ... and holds this share of the object's pixels: a face turned away more than this is a sliver.
LEAST_REGION_SHARE = 0.02
# The blurred rim of a face, px: it has the greys of neither face and is no region of its own.
RIM_PX = 2
# The 8 neighbours are averaged this many times: a Gaussian of sqrt(.75 passes) = 1.9 px, which
# separates faces that differ by less than a picture's noise, and is no wider than their rim.
PASSES = 5
# What that leaves of white noise: 1 / (2 sqrt(pi) 1.9).
PASSES_NOISE = 0.146
# Bins of the averages' histogram, and its least smoothing, grey levels: rounding of the picture
# to whole levels leaves .29 / sqrt(40) of them, so half a level is beyond it.
GREY_LEVELS = 256
BIN_GREY = 0.25
LEAST_SMOOTHING_GREY = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class PlaneRegions:
    """Regions of one picture: labels (H, W), 0 outside the object, 1..count in it; thresholds."""

    labels: NDArray[np.int32]
    count: int
    thresholds: tuple[float, ...]


def average_neighbours(image: Image, mask: Image, passes: int = PASSES) -> FloatArray:
    """Return the mean of each pixel's 8 neighbours on the mask (step 6), taken `passes` times; grey
    levels.

    Neighbours off the mask do not count, so the ground does not darken the object's rim.
    """
    ring = np.ones((3, 3), dtype=np.float32)
    ring[1, 1] = 0.0
    inside = (mask > 0).astype(np.float32)
    neighbours = cv2.filter2D(inside, -1, ring, borderType=cv2.BORDER_CONSTANT)
    share = np.where(inside > 0, 1.0 / np.maximum(neighbours, 1.0), 0.0).astype(np.float32)
    mean = image.astype(np.float32) * inside
    for _ in range(passes):
        mean = cv2.filter2D(mean, -1, ring, borderType=cv2.BORDER_CONSTANT) * share
    return mean.astype(np.float64)


def find_grey_thresholds(means: FloatArray, sd_grey: float) -> tuple[float, ...]:
    """Return thresholds between the peaks of the histogram of averages (n,), rising; none if it has
    one.

    `sd_grey` is the averages' noise. Each threshold is the lowest point after a peak, which is as
    far above the peak as its pixels reach.
    """
    bins = round(GREY_LEVELS / BIN_GREY)
    counts = np.histogram(means, bins=bins, range=(0.0, float(GREY_LEVELS)))[0].astype(np.float64)
    smooth = gaussian_filter1d(
        counts, max(LEAST_SMOOTHING_GREY, sd_grey) / BIN_GREY, mode="constant"
    )
    padded = np.concatenate([[0.0], smooth, [0.0]])  # a peak may be at either end of the scale
    peaks, found = find_peaks(padded, prominence=0.0)
    kept = peaks[found["prominences"] >= PEAK_PROMINENCE * padded[peaks]] - 1
    least = LEAST_REGION_SHARE * counts.sum()
    thresholds: list[int] = []
    begin = 0
    for low, high in pairwise(kept):
        valley = int(low + np.argmin(smooth[low : high + 1]))
        if counts[begin:valley].sum() >= least:
            thresholds.append(valley)
            begin = valley
    if thresholds and counts[begin:].sum() < least:
        thresholds.pop()
    return tuple(float(threshold * BIN_GREY) for threshold in thresholds)


def plane_regions(image: Image, mask: Image, sd_grey: float | None = None) -> PlaneRegions:
    """Return the object's pixels parted into regions of one grey each; every pixel of the mask is
    in one.

    `sd_grey` is the noise of the picture in grey levels; estimated if not given.
    """
    labels = np.zeros(mask.shape, dtype=np.int32)
    area = int(np.count_nonzero(mask))
    if not area:
        return PlaneRegions(labels, 0, ())
    u, v, width, height = cv2.boundingRect(mask)
    window = np.s_[v : v + height, u : u + width]
    inside = mask[window]
    noise = noise_sd(image) if sd_grey is None else sd_grey
    mean = average_neighbours(image[window], inside)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * RIM_PX + 1, 2 * RIM_PX + 1))
    core = cv2.erode(inside, disc, borderType=cv2.BORDER_CONSTANT, borderValue=0).astype(np.uint8)
    thresholds = find_grey_thresholds(mean[core > 0], noise * PASSES_NOISE)
    bounds = (-np.inf, *thresholds, np.inf)
    seeds = np.zeros(inside.shape, dtype=np.int32)
    count = 0
    for low, high in pairwise(bounds):
        band = ((mean >= low) & (mean < high) & (core > 0)).astype(np.uint8)
        band = cv2.morphologyEx(band, cv2.MORPH_OPEN, disc).astype(np.uint8)
        parts, part_labels, stats, _ = cv2.connectedComponentsWithStats(band, connectivity=4)
        for part in range(1, parts):
            if stats[part, cv2.CC_STAT_AREA] >= LEAST_REGION_SHARE * area:
                count += 1
                seeds[part_labels == part] = count
    if not count:  # too thin for a core: one region
        seeds, count = (inside > 0).astype(np.int32), 1
    labels[window] = np.where(inside > 0, _nearest(seeds), 0)
    return PlaneRegions(labels, count, thresholds)


def _nearest(seeds: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return for each pixel the label of the nearest pixel that has one."""
    empty = (seeds == 0).astype(np.uint8)
    _, nearest = cv2.distanceTransformWithLabels(
        empty, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    table = np.zeros(int(nearest.max()) + 1, dtype=np.int32)
    table[nearest[seeds > 0]] = seeds[seeds > 0]
    spread: NDArray[np.int32] = table[nearest]
    return spread
