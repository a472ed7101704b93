"""A length that someone knows, of a scene whose unit is unknown: it makes metres of all lengths."""

import math
from dataclasses import dataclass

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.length_units import parse_length
from facetlog.perception.ragged import Indices
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.scaled_scene import in_metres
from facetlog.perception.types import FloatArray

EXAMPLES = '"v3 v7 = 25 cm", "e5 = 25 ± 0.1 cm", "height = 74 cm" or "height t2 = 74 cm"'


@dataclass(frozen=True, slots=True)
class KnownLength:
    """The distance of two vertices, the length of an edge, or how high a thing is; in metres.

    `of` are the words that name it: two vertices, an edge, or "height" and perhaps the thing.
    """

    of: tuple[str, ...]
    metres: float
    sd: float = 0.0

    @classmethod
    def parse(cls, text: str, option: str = "--scale") -> "KnownLength":
        """Return the length that a text states; InputError for another, which names the option.

        >>> KnownLength.parse("v3 v7 = 25 ± 0.5 cm")
        KnownLength(of=('v3', 'v7'), metres=0.25, sd=0.005)
        """
        words, equals, value = text.partition("=")
        if not (words.strip() and equals):
            raise InputError(f"{option} {text!r:.60}: give a known length as {EXAMPLES}")
        length = parse_length(value, f"{option} {words.strip()!r:.40} =")
        return cls(tuple(words.split()), length.metres, length.sd or 0.0)


@dataclass(frozen=True, slots=True)
class Scale:
    """Metres in a scene's unit, and their standard deviation."""

    metres: float
    sd: float

    def __str__(self) -> str:
        digits = 1 - math.floor(math.log10(self.sd)) if self.sd > 0 else 6
        return f"the scene's unit is {self.metres:.{digits}f} ± {self.sd:.2g} m"


def scale_by_known_length(scene: Scene, known: KnownLength) -> tuple[Scene, Scale]:
    """Return the scene in metres by a length that is known in it, and the scale that follows.

    The scale is as sure as the known length and that length as it was measured here (in_metres
    says how that goes into the scene). InputError where the lengths are metres already, where the
    scene has nothing of that name, and for the height where up is not known.
    """
    if scene.metric:
        raise InputError("the lengths are metres already: leave out the unit, or the known length")
    start, end, along = _ends(scene, known.of)
    points, covs = scene.points, [scene.vertices[k].cov for k in (start, end)]
    difference = points[end] - points[start]
    length = float(difference @ along)
    if not length > 0:
        raise InputError(f"{' '.join(known.of)} is of length 0 here: give another known length")
    variance = float(sum(along @ cov @ along for cov in covs))
    metres = known.metres / length
    relative = math.hypot(known.sd / known.metres, math.sqrt(max(variance, 0.0)) / length)
    return in_metres(scene, metres, relative), Scale(metres, metres * relative)


def _ends(scene: Scene, of: tuple[str, ...]) -> tuple[int, int, FloatArray]:
    """Return the two vertices between which a length is measured, and the unit vector along it."""
    memo = SceneMemo.of(scene)
    match of:
        case (str(name),) if name.startswith("e"):
            start, end = memo.edges[_place(name, [str(each) for each in memo.edge_names], "edge")]
        case (str(one), str(other)) if one.startswith("v"):
            names = [f"v{k}" for k in range(1, len(scene.vertices) + 1)]
            start, end = _place(one, names, "vertex"), _place(other, names, "vertex")
        case ("height",) | ("height", _):
            return _height(scene, memo, of[1:])
        case _:
            raise InputError(f"{' '.join(of)!r:.40} is no length in a scene: give {EXAMPLES}")
    difference = scene.points[end] - scene.points[start]
    norm = float(np.linalg.norm(difference))
    return int(start), int(end), difference / (norm or 1.0)


def _height(scene: Scene, memo: SceneMemo, thing: tuple[str, ...]) -> tuple[int, int, FloatArray]:
    if scene.up is None:
        raise InputError(
            "the height is not known without up: state which way is up, or another known length"
        )
    names = [str(name) for name in memo.thing_names]
    if not thing and len(names) != 1:
        raise InputError(f'the scene has {len(names)} things: name one, as in "height t1 = 74 cm"')
    of_thing: Indices = memo.members[_place(thing[0], names, "thing") if thing else 0]
    heights = scene.points[of_thing] @ scene.up
    return int(of_thing[heights.argmin()]), int(of_thing[heights.argmax()]), scene.up


def _place(name: str, names: list[str], kind: str) -> int:
    if name not in names:
        known = f"they are {names[0]} to {names[-1]}" if names else "it has none"
        raise InputError(f"the scene has no {kind} {name!r:.20}: {known}")
    return names.index(name)
