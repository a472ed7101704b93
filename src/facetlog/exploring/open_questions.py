"""Open questions about the thing at a target: verdicts that are undecided, and why.

A verdict turns by what was not seen, by an error of measurement, or because what nobody looked at
was taken to be as what was seen: a box is full behind the sides that show.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy.special import ndtr

from facetlog.exploring.sides import Sides
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.space.space import UnseenSpace
from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Condition, Recognition, Verdict

LEAST_TURNED = 0.005
"""A verdict that may turn with less probability is decided: degrees are said in whole per cents."""
# Of two verdicts that contradict one another either is wrong.
CONTRADICTED = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Interest:
    """Object of interest: the thing that stands at `target` (3,), or nearest to it within `radius`
    (m), after looks from `places` (v, 3).
    """

    target: FloatArray
    radius: float
    places: FloatArray


class Lack(Enum):
    """Missing information that would settle an open condition: views of sides, looks into space, or
    corners that are better known.
    """

    SIDES = "sides"
    SPACE = "space"
    CORNERS = "corners"


@dataclass(frozen=True, slots=True)
class Open:
    """A verdict that may turn: with the probability `unseen` once what its open conditions `lack`
    is seen, with `assumed` because sides that nobody looked at are not as they were taken to be,
    with `measured` by an error of measurement (at most 1/2: else it would be the other verdict).

    `likely` is how probably it is the thing's name though it does not hold, `general` are the
    models of which it is a special case. The model is empty where no thing was found to ask of.
    """

    thing: str
    model: str
    unseen: float = 0.0
    measured: float = 0.0
    assumed: float = 0.0
    lack: frozenset[Lack] = frozenset({Lack.SIDES})
    likely: float = 0.0
    general: tuple[str, ...] = ()

    @property
    def mass(self) -> float:
        """The probability that it turns, by any of them."""
        return min(self.unseen + self.measured + self.assumed, 1.0)


@dataclass(frozen=True, slots=True)
class Lead:
    """The name that stands first of a thing, and the degrees of all that hold of it by model.

    `general` are the models of which the first is a special case.
    """

    thing: str
    model: str
    degrees: Mapping[str, float]
    general: tuple[str, ...] = ()

    def degree_of(self, model: str) -> float:
        """Return the degree to which the thing is that, 0 where it is something else first."""
        leads = model == self.model or model in self.general
        return self.degrees.get(model, 0.0) if leads else 0.0


@dataclass(frozen=True, eq=False, slots=True)
class SeenThing:
    """A thing as known so far: its `middle` (3,), the `corners` (n, 3) of its faces with `covs`
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
    """Open questions, the things they are about, and the leading name, if any."""

    open: tuple[Open, ...]
    things: tuple[SeenThing, ...]
    lead: Lead | None = None

    @classmethod
    def of_nothing(cls, target: FloatArray) -> "Needs":
        """Return the needs before any thing was found: all of the target is open."""
        none = np.zeros((0, 3))
        thing = SeenThing("", target, none, np.zeros((0, 3, 3)), np.zeros((0, 1, 3)), none, None)
        return cls((Open("", "", 1.0),), (thing,))

    @property
    def mass(self) -> float:
        """Expected number of verdicts that turn: the sum of their probabilities."""
        return sum(each.mass for each in self.open)

    def asked_of(self, model: str) -> "Needs":
        """Return what may make a model's verdict another: its own, and that of the name
        that leads.
        """
        lead = None if self.lead is None else (self.lead.thing, self.lead.model)
        found = [e for e in self.open if e.model in {model, ""} or (e.thing, e.model) == lead]
        return Needs(tuple(found), self.things, self.lead)

    def of_rivals(self) -> "Needs":
        """Return what may topple the name that leads: one that is open counts as far as it is
        likely to take its place, not as far as it is undecided.
        """
        found = (replace(e, unseen=min(e.unseen, e.likely)) for e in self.open)
        left = tuple(each for each in found if each.mass >= LEAST_TURNED)
        return Needs(left, self.things, self.lead)

    def contradicted(self) -> "Needs":
        """Return the same where the views before the last one ruled out the name that leads: of two
        verdicts that contradict one another either may be wrong, and the last is no better.
        """
        if self.lead is None:
            return self
        thing, model = self.lead.thing, self.lead.model
        rest = tuple(e for e in self.open if (e.thing, e.model) != (thing, model))
        own = next((e for e in self.open if (e.thing, e.model) == (thing, model)), None)
        doubted = replace(own or Open(thing, model), assumed=CONTRADICTED)
        return Needs((doubted, *rest), self.things, self.lead)

    @property
    def overtaken(self) -> float:
        """Probability that another name would lead if everything had been seen, 0..1."""
        if self.lead is None:
            return 1.0
        lead, chance = self.lead, 0.0
        for each in self.open:
            if each.thing != lead.thing:
                continue
            if each.model == lead.model:
                chance += each.assumed
            elif lead.model not in each.general:
                chance += each.likely
        return min(chance, 1.0)


def find_needs(scene: Scene, found: "Recognition", interest: Interest) -> Needs:
    """Return what is open of the thing at the target."""
    things = tuple(_things(scene, interest))
    names = {thing.name for thing in things}
    asked = [v for v in found.verdicts if v.thing in names]
    if not asked:
        return Needs.of_nothing(interest.target)
    best = next((v for v in found.best if v.thing in names), None)
    lead = None
    if best is not None:
        degrees = {v.model: v.degree for v in found.best if v.thing == best.thing}
        lead = Lead(best.thing, best.model, degrees, best.specialises)
    lacks = {t.name: Sides(t.middle, t.normals, interest.places).lack for t in things}
    return Needs(tuple(_open(asked, lacks)), things, lead)


def _open(verdicts: "Sequence[Verdict]", lacks: dict[str, float]) -> Iterator[Open]:
    from facetlog.kb.explaining.proof import State

    models = {verdict.model for verdict in verdicts}
    sure: dict[str, float] = {}
    for verdict in verdicts:
        if verdict.state is State.HOLDS:
            sure[verdict.thing] = max(verdict.sure, sure.get(verdict.thing, 0.0))
    for verdict in verdicts:
        # Were the name wrong, what was not looked at would show it, and any other may be right.
        wrong = (1.0 - sure.get(verdict.thing, 0.0)) * lacks[verdict.thing]
        if verdict.state is State.HOLDS:
            wrong = (1.0 - verdict.sure) * lacks[verdict.thing]
            opened = Open(verdict.thing, verdict.model, 0.0, _doubt(verdict), wrong)
        elif verdict.state is State.UNKNOWN and verdict.is_unseen:
            width = verdict.degree_at_most - verdict.degree
            lack = frozenset(map(_lack, (c for c in verdict.conditions if c.may_be_settled)))
            lack = lack or frozenset({Lack.SIDES})
            opened = Open(
                verdict.thing,
                verdict.model,
                width,
                lack=lack,
                likely=verdict.sure,
                general=verdict.specialises,
            )
        else:
            opened = Open(verdict.thing, verdict.model, 0.0, _doubt(verdict), wrong / len(models))
        if opened.mass >= LEAST_TURNED:
            yield opened


def _lack(condition: "Condition") -> Lack:
    """Return what the step that leaves a condition open says that it lacks."""
    from facetlog.kb.explaining.proof import Comparison
    from facetlog.kb.explaining.reasons import reason

    found = reason(condition.proof)
    step = None if found is None else found.step.detail
    if not isinstance(step, Comparison):
        return Lack.SIDES  # a face that was not seen, or of which there may be more
    if step.unseen is not None:
        return Lack.SPACE
    return Lack.CORNERS if step.shortfall is None else Lack.SIDES


def _doubt(verdict: "Verdict") -> float:
    """Return the probability that the true values are beyond the nearest limit that turns the
    verdict.

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
    at = shapely.Point(interest.target[:2])
    away = {
        index: shapely.MultiPoint(scene.points[memo.members[index]][:, :2]).convex_hull.distance(at)
        for index in range(len(memo.things))
        if len(memo.members[index])
    }
    nearest = min(away.values(), default=math.inf)
    for index, (thing, name) in enumerate(zip(memo.things, names, strict=True)):
        # All that it stands in, as parts of one thing that do not touch; else the nearest.
        if away.get(index, math.inf) > min(nearest, interest.radius):
            continue
        faces = [scene.faces[i] for i in thing.faces]
        corners = sorted({k for face in faces for k in face.outline})
        members = scene.points[memo.members[index]]
        middle = (members.min(axis=0) + members.max(axis=0)) / 2
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
