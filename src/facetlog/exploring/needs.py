"""What is undecided after some views, and what of things was not seen or is poorly known.

A verdict that is open turns as probably as its degree's bounds are apart; one that was measured as
probably as an error of measurement turns it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.space.open_lines import UnseenSpace
from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition, Verdict

__all__ = ["LEAST_TURNED", "Interest", "Needs", "Open", "SeenThing", "needs_of"]

LEAST_TURNED = 0.005
"""A verdict that may turn with less probability is decided: degrees are said in whole per cents."""


@dataclass(frozen=True, eq=False, slots=True)
class Interest:
    """What is asked: things within `radius` (m) of `target` (3,), and which `models`, all if ()."""

    target: FloatArray
    radius: float
    models: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Open:
    """A verdict that may turn: by what was not seen with the probability `unseen`, by what is
    poorly measured with `measured` (at most 1/2: else it would be the other verdict).

    The model is empty where no thing was found to ask of.
    """

    thing: str
    model: str
    unseen: float
    measured: float

    @property
    def mass(self) -> float:
        """The probability that it turns, by either."""
        return self.unseen + self.measured


@dataclass(frozen=True, eq=False, slots=True)
class SeenThing:
    """What is known of a thing: its `middle` (3,), the `corners` (n, 3) of its faces with `covs`
    (n, 3, 3), the outward normals `facing` (n, m, 3) of the faces of each, rows of zeros for none,
    the `normals` (k, 3) of faces that nobody measured, and what is unseen of its space.
    """

    name: str
    middle: FloatArray
    corners: FloatArray
    covs: FloatArray
    facing: FloatArray
    normals: FloatArray
    space: UnseenSpace | None


@dataclass(frozen=True, eq=False, slots=True)
class Needs:
    """What is open, of which things."""

    open: tuple[Open, ...]
    things: tuple[SeenThing, ...]

    @classmethod
    def of_nothing(cls, target: FloatArray) -> "Needs":
        """Where no thing was found yet, all of the target is open."""
        none = np.zeros((0, 3))
        thing = SeenThing("", target, none, np.zeros((0, 3, 3)), np.zeros((0, 1, 3)), none, None)
        return cls((Open("", "", 1.0, 0.0),), (thing,))

    @property
    def mass(self) -> float:
        """How many verdicts may turn, as the sum of their probabilities."""
        return sum(each.mass for each in self.open)


def needs_of(scene: Scene, found: "Recognition", interest: Interest) -> Needs:
    """What is open of the things within the radius round the target."""
    things = tuple(_things(scene, interest))
    names = {thing.name for thing in things}
    asked = [v for v in found.verdicts if v.thing in names]
    if not asked:
        return Needs.of_nothing(interest.target)
    return Needs(tuple(_open(asked, interest.models)), things)


def _open(verdicts: "Sequence[Verdict]", wanted: Sequence[str]) -> Iterator[Open]:
    from facetlog.kb.explaining.proof import State

    fits = {verdict.thing for verdict in verdicts if verdict.state is State.HOLDS}
    models = {verdict.model for verdict in verdicts}
    for verdict in verdicts:
        if wanted and verdict.model not in wanted:
            continue
        unseen = measured = 0.0
        if verdict.is_unseen:
            unseen = verdict.degree_at_most - verdict.degree
        else:
            measured = _doubt(verdict)
            if verdict.thing not in fits:
                # No model fits what was seen of it, which may be half a thing: each may be it.
                unseen = 1.0 / len(models)
        if unseen + measured >= LEAST_TURNED:
            yield Open(verdict.thing, verdict.model, unseen, measured)


def _doubt(verdict: "Verdict") -> float:
    """The probability that the true values are beyond the nearest limit that turns the verdict.

    A degree is less than 1 also where a tolerance is soft, or where something that is expected is
    not there: no view changes that.
    """
    from facetlog.kb.explaining.margins import turned

    if min(verdict.degree, 1.0 - verdict.degree) < LEAST_TURNED:
        return 0.0
    changes = (margin.sds for margin in turned(verdict))
    return max((float(ndtr(-sds)) for sds in changes if sds is not None), default=0.0)


def _things(scene: Scene, interest: Interest) -> Iterator[SeenThing]:
    from facetlog.perception.facts.scene_memo import SceneMemo

    memo = SceneMemo.of(scene)
    names = memo.thing_names
    for index, (thing, name) in enumerate(zip(memo.things, names, strict=True)):
        faces = [scene.faces[i] for i in thing.faces]
        corners = sorted({k for face in faces for k in face.outline})
        members = scene.points[memo.members[index]]
        if not len(members):
            continue
        middle = (members.min(axis=0) + members.max(axis=0)) / 2
        if math.dist(middle[:2], interest.target[:2]) > interest.radius:
            continue
        of_corner = [[f.plane.normal for f in faces if k in f.outline] for k in corners]
        facing = np.zeros((len(corners), max(map(len, of_corner), default=1), 3))
        for row, normals in zip(facing, of_corner, strict=True):
            row[: len(normals)] = normals
        implied = [f.plane.normal for f in faces if f.evidence is Evidence.IMPLIED]
        filled = memo.filled.get(index)
        space = None if filled is None or filled.known else UnseenSpace.of(filled.space)
        yield SeenThing(
            str(name),
            middle,
            scene.points[corners],
            np.array([scene.vertices[k].cov for k in corners]).reshape(-1, 3, 3),
            facing,
            np.array(implied).reshape(-1, 3),
            space if space is not None and len(space.points) else None,
        )
