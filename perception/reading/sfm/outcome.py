"""Request and outcome of structure from motion, and why it found nothing, or not all pictures."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from facetlog.perception.reading.image_sources import Shot
from facetlog.perception.reading.skipped_images import LeftOut

LEAST_PICTURES = 3
"""Least number for a model: two pictures agree with a wrong focal length as with the right one."""
START_POINTS = 100
"""Points that two pictures must have in common for COLMAP to begin with them."""
MAT = "use a printed mat (facetlog mat -o mat.pdf)"


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of structure from motion; cameras are found anew when they change."""

    camera: str = "RADIAL"
    """A focal length, k1 and k2: the lenses of phones. The principal point stays in the middle:
    pictures alone hardly say where it is."""

    most_features: int = 4096
    """Features of a picture. Poses are no better with twice as many, and worse by two fifths with
    half as many (docs/decisions.md)."""

    longest_side_px: int = 1600
    """Side to which larger pictures are reduced for features; time grows with their pixels."""

    seed: int = 0


@dataclass(frozen=True, slots=True)
class Request:
    """The pictures, an empty folder to work in, one for the model, and how many threads."""

    shots: tuple[Shot, ...]
    work: Path
    model: Path
    threads: int
    settings: Settings


@dataclass(frozen=True, slots=True)
class Pair:
    """Two pictures, by their names, and how many points they were found to have in common."""

    one: str
    other: str
    points: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """How structure from motion went.

    `features` of each picture that could be read; `unreadable` are the others. `pairs` are those
    with points in common. `groups` are the pictures that were placed together, the largest first,
    which is the one that is used; its points lie `error_px` from where the pictures show them.
    """

    features: Mapping[str, int]
    unreadable: tuple[LeftOut, ...] = ()
    pairs: tuple[Pair, ...] = ()
    groups: tuple[tuple[str, ...], ...] = ()
    error_px: float = 0.0


def explain_failure(outcome: Outcome) -> str:
    """Return why no pictures were placed, and what to do."""
    count = len(outcome.features)
    if count < LEAST_PICTURES:
        few = f"{count} can be read: {outcome.unreadable[0].line}" if outcome.unreadable else ""
        return few or (
            f"without one at least {LEAST_PICTURES} pictures are needed, better 12 to 30 from all "
            "round the thing"
        )
    most = max((pair.points for pair in outcome.pairs), default=0)
    if most >= START_POINTS:
        return (
            f"what they have in common, up to {most} points, was taken from places that do not lie "
            f"apart: walk round the thing, do not turn on the spot, or {MAT}"
        )
    usual = round(median(outcome.features.values()))
    if usual < START_POINTS:
        return (
            f"what they show has too little texture, {usual} features in a usual one: lay "
            f"printed paper under the thing, or {MAT}"
        )
    joined, all_pairs = len(outcome.pairs), count * (count - 1) // 2
    in_common = f", {most} at most" if most else ""
    return (
        f"only {joined} of {all_pairs} pairs of pictures have points in common{in_common}: take "
        f"one every 10 to 15 degrees, of what does not repeat itself, or {MAT}"
    )


def left_out(outcome: Outcome, places: Mapping[str, str]) -> tuple[LeftOut, ...]:
    """Return the pictures that are not used, and why; `places` are their files, by their names."""
    used, *others = outcome.groups
    placed = set(used)
    found = list(outcome.unreadable)
    for group in others:
        rest = [name for name in group if name not in placed]
        apart = f"is one of {len(rest)} that do not join the {len(used)} that are used"
        found += _list_left_out(rest, places, f"{apart}: take some between")
        placed.update(rest)
    lost = [name for name in outcome.features if name not in placed]
    few = "has too few points in common with the others: take some between"
    return (*found, *_list_left_out(lost, places, few))


def _list_left_out(names: Iterable[str], places: Mapping[str, str], why: str) -> list[LeftOut]:
    return [LeftOut(name, f"picture {places[name]} {why}", places[name]) for name in names]
