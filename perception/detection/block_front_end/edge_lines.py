"""Steps 3 and 4 of the algorithm: edge pixels, traced into chains that are cut into straight edges.

Section 5.3: "The Laplacian operator then is used to determine the edges of the block ... the
pixels on the edges are traced". An edge pixel is a zero crossing of the Laplacian of the smoothed
picture (Marr and Hildreth 1980) whose gradient stands out of the noise. "At each pixel the change
in geometric direction gradient is determined. The pixels having a change in slope greater than 30
degrees are regarded as the 2-D vertices". Between two such pixels the edge is straight; its line is
then fitted to the grey levels, which places it some ten times better than the pixels of the chain.
"""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import FloatArray, Image

# Smoothing before the Laplacian, px: enough to make its zero crossings connected at the noise of
# ordinary cameras, and no wider than the pictures' own blur.
SMOOTHING_PX = 1.4
# A zero crossing is an edge where the gradient is this many times its own noise. A Rayleigh
# distributed gradient passes 5 sd once in 270,000 pixels.
GRADIENT_SIGNIFICANCE = 5.0
# An edge also has a step of a few grey levels, so that a noiseless picture's rounding is none.
LEAST_STEP_GREY = 4.0
# The edge lies within this distance of the thresholded region's border, px: the reach of the
# smoothing (2 sd) and a pixel of the threshold's own bias.
BAND_PX = 4

# Neighbours in the order of a walk: straight ones first, so that chains take no corner short cut.
_NEIGHBOURS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))


def find_edge_pixels(image: Image, mask: Image, sd_grey: float | None = None) -> NDArray[np.bool_]:
    """Return zero crossings (H, W) of the Laplacian in and just round the mask, one pixel thin.

    `sd_grey` is the noise of the picture in grey levels; estimated if not given.
    """
    noise = noise_sd(image) if sd_grey is None else sd_grey
    found = np.zeros(image.shape, dtype=np.bool_)
    if not mask.any():
        return found
    # Only the window of the mask is worked on.
    u, v, w, h = cv2.boundingRect(mask)
    margin = BAND_PX + int(np.ceil(4 * SMOOTHING_PX))
    rows = slice(max(0, v - margin), min(image.shape[0], v + h + margin))
    columns = slice(max(0, u - margin), min(image.shape[1], u + w + margin))
    smooth = cv2.GaussianBlur(image[rows, columns].astype(np.float32), (0, 0), SMOOTHING_PX)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * BAND_PX + 1, 2 * BAND_PX + 1))
    near = cv2.dilate(mask[rows, columns], disc) > 0

    gradient_u = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1.0 / 8.0)
    gradient_v = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1.0 / 8.0)
    gradient = np.hypot(gradient_u, gradient_v)
    # White noise of sd s has gradients of sd s / (sqrt(8 pi) b²) after a Gaussian of b pixels;
    # a step of C grey levels has C / (sqrt(2 pi) b) (the pictures' own blur left out).
    gradient_sd = noise / (np.sqrt(8.0 * np.pi) * SMOOTHING_PX**2)
    weakest = max(
        GRADIENT_SIGNIFICANCE * gradient_sd, LEAST_STEP_GREY / (np.sqrt(2 * np.pi) * SMOOTHING_PX)
    )
    laplacian = cv2.Laplacian(smooth, cv2.CV_32F, ksize=1)
    positive = laplacian > 0
    crossing = np.zeros(smooth.shape, dtype=np.bool_)
    magnitude = np.abs(laplacian)
    # The edge pixel is, of two neighbours with different signs, the one nearer to zero.
    across = positive[:, 1:] != positive[:, :-1]
    left = magnitude[:, :-1] <= magnitude[:, 1:]
    crossing[:, :-1] |= across & left
    crossing[:, 1:] |= across & ~left
    down = positive[1:] != positive[:-1]
    upper = magnitude[:-1] <= magnitude[1:]
    crossing[:-1] |= down & upper
    crossing[1:] |= down & ~upper
    found[rows, columns] = crossing & near & (gradient >= weakest)
    # The picture's own rim is no edge of a thing.
    found[[0, -1], :] = False
    found[:, [0, -1]] = False
    return found


def trace_chains(edges: NDArray[np.bool_], least_pixels: int) -> tuple[FloatArray, ...]:
    """Return chains of neighbouring edge pixels (u, v), each (n, 2) with n >= `least_pixels`.

    A chain is walked from an end where there is one; where edges fork it goes on and the other
    branch becomes a chain of its own. A closed chain repeats its first pixel at its end.
    """
    count, labels = cv2.connectedComponents(edges.astype(np.uint8), connectivity=8)
    sizes = np.bincount(labels.ravel(), minlength=count)
    sizes[0] = 0
    kept = (sizes >= least_pixels)[labels]
    degree = cv2.boxFilter(
        kept.astype(np.uint8), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    rows, columns = np.nonzero(kept)
    by_degree = np.argsort(degree[rows, columns], kind="stable")  # ends before middles
    left = set(zip(rows.tolist(), columns.tolist(), strict=True))
    chains = []
    starts = zip(rows[by_degree].tolist(), columns[by_degree].tolist(), strict=True)
    for start in starts:
        if start not in left:
            continue
        left.discard(start)
        forward = _walk(start, left)
        backward = _walk(start, left)
        chain = [*reversed(backward), start, *forward]
        if len(chain) < least_pixels:
            continue
        if max(abs(chain[0][0] - chain[-1][0]), abs(chain[0][1] - chain[-1][1])) <= 1:
            chain.append(chain[0])
        chains.append(np.array(chain, dtype=np.float64)[:, ::-1].copy())
    return tuple(chains)


def _walk(start: tuple[int, int], left: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return pixels from `start` on, taken out of `left`, until none is next to the last."""
    walked = []
    row, column = start
    while True:
        for down, right in _NEIGHBOURS:
            step = (row + down, column + right)
            if step in left:
                left.discard(step)
                walked.append(step)
                row, column = step
                break
        else:
            return walked


# The paper's change in slope at a vertex (algorithm, step 4), radians.
SLOPE_CHANGE = np.deg2rad(30.0)
# Slopes are chords over this many pixels of chain: on the grid 8 pixels resolve 7 degrees.
SUPPORT_PX = 8
# A piece that bows more than this is bent below SLOPE_CHANGE somewhere and is cut there; traced
# pixels of a straight edge stay within .5 px of rounding and about as much of noise.
MOST_BOW_PX = 1.2
# Half the length of the grey profiles across an edge, px: the step is over by 2.5 blur, and two
# pixels of each side give its grey level.
HALF_PROFILE_PX = 5
ACROSS_PX = np.arange(-HALF_PROFILE_PX, HALF_PROFILE_PX + 0.5, 0.5)
# Assumed blur (lens and pixel), px; a fit at the wrong blur has no bias.
NOMINAL_BLUR_PX = 1.1
# Grey levels beside an edge are averaged over this many pixels along it.
LEVEL_SPAN_PX = 15
FIT_STEPS = 4
# Fewer profiles than this do not determine offset and angle and also their scatter.
LEAST_PROFILES = 5
# Steps end when the line moves less than this, px: a tenth of the best line's own error.
SETTLED_PX = 0.01
# An edge goes on while its step, mean over GAP_PX, is at least this share of its contrast.
SAME_STEP_SHARE = 0.5
GAP_PX = 5
# ... and while it does not drift off the line, px, or sd where the noise is larger: an edge that
# turns by 10 degrees has left by as much after 5 pixels.
DRIFT_PX = 0.8
DRIFT_SD = 3.0
# Outliers: offsets beyond this many robust sd are of another edge (Rousseeuw and Leroy 1987).
OUTLIER_SD = 2.5
# Standard deviation over median magnitude of a Gaussian.
MAD_TO_SD = 1.4826
# A line that passes a vertex by more than this share of its length on both sides ends elsewhere.
PASSING_SHARE = 0.2
# Calibration, sampling and a not quite straight real edge leave at least this, px.
MODEL_SD_PX = 0.02


@dataclass(frozen=True, eq=False, slots=True)
class EdgeLine:
    """A straight edge in one picture, from `start` to `end` (u, v), with its brighter side right.

    `cov` (2, 2) is of (offset along the normal at the middle in px, angle in radians).
    `contrast` is in grey levels. The normal is the direction turned by 90° to the right as seen.
    """

    start: FloatArray
    end: FloatArray
    cov: FloatArray
    contrast: float

    @property
    def length(self) -> float:
        """Length in pixels."""
        return float(np.hypot(*(self.end - self.start)))

    @property
    def direction(self) -> FloatArray:
        """Unit vector from start to end, (2,)."""
        along: FloatArray = self.end - self.start
        return along / float(np.hypot(*along))

    @property
    def normal(self) -> FloatArray:
        """Unit normal (2,), towards the brighter side."""
        du, dv = self.direction
        return np.array([-dv, du])

    @property
    def middle(self) -> FloatArray:
        """Middle of the edge, (2,)."""
        half: FloatArray = (self.start + self.end) / 2.0
        return half

    def leaving(self, uv: FloatArray) -> list[tuple[FloatArray, bool]]:
        """Return the far ends (2,) as seen from a vertex on the line, and whether it runs that way.

        A line that goes on past the vertex by more than PASSING_SHARE leaves on both sides.
        """
        along = float((uv - self.start) @ self.direction) / self.length
        ends = []
        if along < 1.0 - PASSING_SHARE:
            ends.append((self.end, True))
        if along > PASSING_SHARE:
            ends.append((self.start, False))
        return ends

    def compute_offset_variance(self, point: FloatArray) -> float:
        """Return the variance (px²) across the line at the foot of `point`, which may lie beyond
        the ends.
        """
        lever = np.array([1.0, float(self.direction @ (point - self.middle))])
        return float(lever @ self.cov @ lever)


def cut_straight_pieces(chain: FloatArray, least_px: float) -> tuple[FloatArray, ...]:
    """Return the straight pieces of a chain (n, 2), cut at slope changes and where a piece bows.

    >>> corner = np.array([[u, 0] for u in range(20)] + [[19, v] for v in range(1, 20)], float)
    >>> [len(piece) for piece in cut_straight_pieces(corner, least_px=8)]
    [20, 20]
    """
    count = len(chain)
    closed = count > 2 * SUPPORT_PX and bool((chain[0] == chain[-1]).all())
    if closed:
        # Open at its sharpest corner, with that pixel at both ends.
        loop = chain[:-1]
        before, after = (np.roll(loop, n, axis=0) for n in (SUPPORT_PX, -SUPPORT_PX))
        loop = np.roll(loop, -int(np.argmax(_turn(before, loop, after))), axis=0)
        chain = np.concatenate([loop, loop[:1]])
        count = len(chain)
    if count <= 2 * SUPPORT_PX:
        return tuple(_cut_bows(chain, least_px))
    middle = chain[SUPPORT_PX:-SUPPORT_PX]
    turn = _turn(chain[: -2 * SUPPORT_PX], middle, chain[2 * SUPPORT_PX :])
    cuts = [0, *(int(i) + SUPPORT_PX for i in _find_peaks_of_turn(turn, SLOPE_CHANGE)), count - 1]
    pieces: list[FloatArray] = []
    for begin, end in pairwise(cuts):
        pieces.extend(_cut_bows(chain[begin : end + 1], least_px))
    return tuple(pieces)


def _turn(before: FloatArray, at: FloatArray, after: FloatArray) -> FloatArray:
    """Return the angle (radians, 0..pi) between the chords before and after each pixel."""
    back, ahead = at - before, after - at
    cross = back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0]
    turn: FloatArray = np.abs(np.arctan2(cross, (back * ahead).sum(axis=1)))
    return turn


def _find_peaks_of_turn(turn: FloatArray, least: float) -> NDArray[np.int64]:
    """Return indices of the largest turns of at least `least`, each SUPPORT_PX from the next."""
    taken: list[int] = []
    for i in np.argsort(-turn, kind="stable"):
        if turn[i] < least:
            break
        if all(abs(int(i) - j) >= SUPPORT_PX for j in taken):
            taken.append(int(i))
    return np.array(sorted(taken), dtype=np.int64)


def _cut_bows(piece: FloatArray, least_px: float) -> list[FloatArray]:
    """Return the piece cut where it is farthest from its chord, until no part bows (Ramer 1972)."""
    pending, straight = [piece], []
    while pending:
        part = pending.pop()
        chord = part[-1] - part[0]
        length = float(np.hypot(*chord))
        if length < least_px:
            continue
        off = np.abs((part - part[0]) @ np.array([-chord[1], chord[0]])) / length
        worst = int(np.argmax(off))
        if off[worst] <= MOST_BOW_PX:
            straight.append(part)
        else:
            pending += [part[worst:], part[: worst + 1]]
    return straight


def fit_edge_line(
    image: Image,
    piece: FloatArray,
    sd_grey: float,
    blur_px: float = NOMINAL_BLUR_PX,
    *,
    steps: int = FIT_STEPS,
) -> EdgeLine | None:
    """Return the line of largest likelihood through a straight piece (n, 2) of an edge, or None.

    Grey profiles across the edge are compared with a blurred step: with levels a and a + C beside
    the edge, residual r(t) and blurred step's slope g(t), the offset of one pixel of edge is
    -(sum g r) / (C sum g²), variance sd² 2 sqrt(pi) blur / C² (research bound for one pixel of
    edge); the line is the weighted fit of those offsets, its covariance scaled up where they
    scatter more than the noise explains. `steps` bounds the rounds of fitting. None where too few
    profiles show a step.
    """
    start, end = _trimmed(piece)
    for step in range(steps):
        length = float(np.hypot(*(end - start)))
        count = int(length) + 1
        if count < LEAST_PROFILES:
            return None
        direction = (end - start) / length
        normal = np.array([-direction[1], direction[0]])
        along = np.linspace(0.0, length, count)
        profiles = _profiles(image, start, direction, along)
        offsets, variances, contrast = _measure_offsets(profiles, sd_grey, blur_px)
        lever = along - length / 2.0
        fit = _fit_robust_line(lever, offsets, variances)
        if fit is None:
            return None
        middle_offset, slope, cov = fit
        start, end = (
            start + normal * (middle_offset - slope * length / 2.0),
            end + normal * (middle_offset + slope * length / 2.0),
        )
        if step and abs(middle_offset) + abs(slope) * length / 2.0 < SETTLED_PX:
            break
    cov = cov + np.diag([MODEL_SD_PX**2, (2.0 * MODEL_SD_PX / length) ** 2])
    if contrast < 0:  # the brighter side is to the right
        start, end = end, start
    return EdgeLine(start, end, cov, abs(contrast))


def extend_line(
    image: Image, line: EdgeLine, sd_grey: float, blur_px: float = NOMINAL_BLUR_PX
) -> tuple[FloatArray, FloatArray]:
    """Return ends (u, v) of the line drawn out as far as the picture shows the same step along it.

    Tracing loses an edge near its ends (the Laplacian's zero crossings leave a corner early) and
    where it is faint; the step itself goes on to the vertex.
    """
    most = max(SUPPORT_PX, round(line.length))
    along = np.arange(-most, int(line.length) + most + 1, dtype=np.float64)
    profiles = _profiles(image, line.start, line.direction, along)
    near = (np.abs(ACROSS_PX) >= 0.5) & (np.abs(ACROSS_PX) <= 2.5)
    step = profiles[:, near & (ACROSS_PX > 0)].mean(axis=1)
    step -= profiles[:, near & (ACROSS_PX < 0)].mean(axis=1)
    span = np.full(GAP_PX, 1.0 / GAP_PX)
    step = np.convolve(step, span, mode="same")
    offsets, variances, _ = _measure_offsets(profiles, sd_grey, blur_px)
    drift = np.abs(np.convolve(offsets, span, mode="same"))
    drifts = drift > np.maximum(DRIFT_PX, DRIFT_SD * np.sqrt(variances / GAP_PX))
    height, width = image.shape
    at = line.start + along[:, None] * line.direction
    inside = (at >= 0).all(axis=1) & (at[:, 0] <= width - 1) & (at[:, 1] <= height - 1)
    inner = np.flatnonzero((along >= 0) & (along <= line.length))
    lost = ~inside | drifts | (step < SAME_STEP_SHARE * line.contrast)
    before, after = np.flatnonzero(lost[: inner[0]]), np.flatnonzero(lost[inner[-1] + 1 :])
    first = before[-1] + 1 if len(before) else 0
    last = inner[-1] + after[0] if len(after) else len(along) - 1
    low, high = min(0.0, along[first]), max(line.length, along[last])
    return line.start + low * line.direction, line.start + high * line.direction


def _profiles(
    image: Image, start: FloatArray, direction: FloatArray, along: FloatArray
) -> FloatArray:
    """Return grey levels (n, m) at ACROSS_PX along the normal, at n places along the line."""
    normal = np.array([-direction[1], direction[0]])
    grid = (
        start[:, None, None]
        + direction[:, None, None] * along[None, :, None]
        + normal[:, None, None] * ACROSS_PX[None, None, :]
    ).astype(np.float32)
    return cv2.remap(
        image, grid[0], grid[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    ).astype(np.float64)


def _trimmed(piece: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ends of the piece's least-squares line, without the stretch that its corners bend."""
    bent = min(SUPPORT_PX // 2, (len(piece) - LEAST_PROFILES) // 4)
    inner = piece[bent:-bent] if bent > 0 else piece
    middle = inner.mean(axis=0)
    _, _, vt = np.linalg.svd(inner - middle, full_matrices=False)
    ends = (inner[[0, -1]] - middle) @ vt[0]
    return middle + vt[0] * ends[0], middle + vt[0] * ends[1]


def _measure_offsets(
    profiles: FloatArray, sd_grey: float, blur_px: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return the offset (px) of the step in each profile (n, m), its variance, and the median
    contrast.
    """
    slope = np.exp(-0.5 * (ACROSS_PX / blur_px) ** 2) / (np.sqrt(2.0 * np.pi) * blur_px)
    step = ndtr(ACROSS_PX / blur_px)
    outer = np.abs(ACROSS_PX) >= 2.5 * blur_px
    below, above = outer & (ACROSS_PX < 0), outer & (ACROSS_PX > 0)
    sums = profiles @ np.column_stack([below / below.sum(), above / above.sum(), slope])
    span = min(LEVEL_SPAN_PX, len(profiles))
    kernel = np.ones(span)
    weights = np.convolve(np.ones(len(profiles)), kernel, mode="same")
    low = np.convolve(sums[:, 0], kernel, mode="same") / weights
    contrast = np.convolve(sums[:, 1], kernel, mode="same") / weights - low
    # sum g r with the residual r = profile - low - contrast step
    matched = sums[:, 2] - low * slope.sum() - contrast * float(step @ slope)
    # A contrast within the noise gives no offset: it is set to its least value.
    safe = np.where(np.abs(contrast) < 1.0, np.where(contrast < 0, -1.0, 1.0), contrast)
    offsets = -matched / (safe * float(slope @ slope))
    noise = max(sd_grey, 1.0 / np.sqrt(12.0))  # rounding to whole grey levels
    variances = noise**2 * 2.0 * np.sqrt(np.pi) * blur_px / safe**2
    # The comparison is linear within about one blur.
    return np.clip(offsets, -2.0 * blur_px, 2.0 * blur_px), variances, _middle(contrast)


def _middle(values: FloatArray) -> float:
    """Return the upper median; numpy's own takes ten times as long on arrays of this size."""
    half = len(values) // 2
    return float(np.partition(values, half)[half])


def _fit_robust_line(
    lever: FloatArray, offsets: FloatArray, variances: FloatArray
) -> tuple[float, float, FloatArray] | None:
    """Return offset at lever 0, slope, and covariance (2, 2) of the line offset + slope lever."""
    residual = offsets - _middle(offsets)
    spread = max(MAD_TO_SD * _middle(np.abs(residual)), 0.05)
    good = np.abs(residual) <= 2.0 * OUTLIER_SD * spread
    weights = 1.0 / variances
    cov = np.zeros((2, 2))
    offset = slope = 0.0
    for _ in range(3):
        w = np.where(good, weights, 0.0)
        wt = w * lever
        s0, s1, s2 = float(w.sum()), float(wt.sum()), float(wt @ lever)
        r0, r1 = float(w @ offsets), float(wt @ offsets)
        determinant = s0 * s2 - s1 * s1
        if np.count_nonzero(good) < LEAST_PROFILES or not determinant > 0:
            return None
        cov = np.array([[s2, -s1], [-s1, s0]]) / determinant
        offset, slope = (s2 * r0 - s1 * r1) / determinant, (s0 * r1 - s1 * r0) / determinant
        residual = offsets - offset - slope * lever
        spread = max(MAD_TO_SD * _middle(np.abs(residual[good])), 0.02)
        good = np.abs(residual) <= OUTLIER_SD * np.maximum(spread, np.sqrt(variances))
    count = np.count_nonzero(good)
    if count < LEAST_PROFILES:
        return None
    chi_square = float((residual**2 * weights)[good].sum() / (count - 2))
    return offset, slope, cov * max(1.0, chi_square)
