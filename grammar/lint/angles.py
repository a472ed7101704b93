"""Angle sets that no solid can have.

The outward normals of faces are unit vectors, and so is the way up. Angles between them come from
`angle`, `dihedral` (through the solid: what is left of 180 degrees after the turn) and `tilt`. What
is measured of three planes obeys the same rules as the planes themselves, so that three angles that
cannot be are an error; what rests on an edge's direction, on members of a set or on a search is a
warning.
"""

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations

from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.lint.bounds import quoted
from facetlog.grammar.lint.claims import Claim, Claims, Place
from facetlog.grammar.lint.directions import (
    FULL,
    GIVE,
    Angles,
    impossible_three,
    left_over,
    vectors_exist,
)
from facetlog.grammar.lint.linear import Linear
from facetlog.grammar.lint.premises import premises
from facetlog.grammar.scope import PartSymbol, SetSymbol
from facetlog.grammar.vocabulary import FACE, PIECE

__all__ = ["Effort", "angle_faults"]

UP = "up"

MOST_FACES = 24
"""Faces of one model that are looked at: every three of them are."""

LEVEL, OPPOSED = 10.0, 165.0
"""Degrees: `level` and `upright` are within 10 of it (rules/vocabulary.pl); `opposite` faces are at
most 15 from opposed (fact_schema.py)."""

# What conditions say of an angle: word, whether it is to the way up, region.
_OF_UP = {"level": (0.0, LEVEL), "upright": (90.0 - LEVEL, 90.0)}


@dataclass(slots=True)
class Effort:
    """What searches may still cost, in steps, over all models of a file."""

    steps: int


@dataclass(frozen=True, slots=True)
class _Known:
    """A region and the claims that it comes from; `sure` if it is proved of what is measured."""

    region: Angles = FULL
    claims: tuple[Claim, ...] = ()
    sure: bool = True

    def within(self, region: Angles, claim: Claim, sure: bool) -> "_Known":
        low, high = max(self.region[0], region[0]), min(self.region[1], region[1])
        if (low, high) == self.region:
            return self
        return _Known((low, high), (*self.claims, claim), self.sure and sure)


@dataclass(slots=True)
class _Angles:
    """What a model says of angles between faces, and between faces and the way up."""

    faces: dict[frozenset[str], _Known] = field(default_factory=dict)
    through: dict[frozenset[str], _Known] = field(default_factory=dict)
    tilts: dict[str, _Known] = field(default_factory=dict)
    sides: dict[str, tuple[str, Claim, bool]] = field(default_factory=dict)

    def add(self, pair: frozenset[str], region: Angles, claim: Claim, sure: bool) -> None:
        if len(pair) == 2:
            self.faces[pair] = self.faces.get(pair, _Known()).within(region, claim, sure)

    def add_dihedral(self, pair: frozenset[str], region: Angles, claim: Claim) -> None:
        # The turn is taken about the edge that was found, which is not quite that of the planes.
        known = self.through.get(pair, _Known((0.0, 360.0)))
        self.through[pair] = known.within(region, claim, False)

    def add_tilt(self, face: str, region: Angles, claim: Claim, sure: bool) -> None:
        known = self.tilts.get(face, _Known((0.0, 90.0)))
        self.tilts[face] = known.within(region, claim, sure)

    def all(self) -> dict[frozenset[str], _Known]:
        """The angles of every two, with those to the way up."""
        found = dict(self.faces)
        for pair, known in self.through.items():
            if len(pair) == 2 and known.region[0] <= known.region[1]:
                before = found.get(pair, _Known())
                (low, high), (least, most) = before.region, _turns(known.region)
                region = max(low, least), min(high, most)
                found[pair] = _Known(region, (*before.claims, *known.claims), False)
        for face in {*self.tilts, *self.sides}:
            tilt = self.tilts.get(face, _Known((0.0, 90.0)))
            low, high = tilt.region
            side, claim, sure = self.sides.get(face, ("", None, True))
            if side == "upward":
                region = low, high
            elif side == "downward":
                region = 180.0 - high, 180.0 - low
            else:
                # Facing up or down: what lies between is left out, as far as that is one region.
                region = low, 180.0 - low
            claims = (*tilt.claims, claim) if claim is not None else tilt.claims
            found[frozenset({face, UP})] = _Known(region, claims, tilt.sure and sure)
        return found


def _turns(through: Angles) -> Angles:
    """The angles of the normals where those through the solid lie so: 90 for 90 and for 270."""
    low, high = 180.0 - through[1], 180.0 - through[0]
    least = 0.0 if low <= 0 <= high else min(abs(low), abs(high))
    return least, max(abs(low), abs(high))


def angle_faults(claims: Claims, reported: set[Place], effort: Effort) -> Iterator[Fault]:
    """Sets of angles that cannot be, each at the last of the model's own lines in it.

    `reported` are the places of claims that have a warning already, and grows.
    """
    found = _angles_of(claims)
    angles = found.all()
    names = sorted({name for pair in angles for name in pair})
    if not names or len(names) > MOST_FACES:
        return
    clean = True
    for pair, known in angles.items():
        if known.region[0] > known.region[1] + GIVE:
            clean = False
            yield from _fault("no two faces have such an angle", (known,), reported, pair)
    if not clean:
        return
    for pair, leaning in _leaning(found):
        clean = False
        yield from _fault("no two faces that lean so have such an angle", leaning, reported, pair)
    if not clean:
        return
    for three in combinations(names, 3):
        pairs = [frozenset(p) for p in combinations(three, 2)]
        if any(p not in angles for p in pairs):
            continue
        known_of = [angles[p] for p in pairs]
        why = impossible_three(*(k.region for k in known_of))
        if why:
            clean = False
            yield from _fault(f"no three faces have such angles: {why}", known_of, reported, three)
    if clean and len(names) > 3:
        yield from _searched(angles, names, reported, effort)


def _leaning(found: _Angles) -> Iterator[tuple[frozenset[str], tuple[_Known, ...]]]:
    """Pairs of faces whose angle their tilts do not allow, and what is known of the three.

    A tilt does not say whether a face looks up or down. Two faces of tilts s and t are turned from
    one another by s + t at most, or by 180 degrees less s + t at least.
    """
    for pair, known in found.all().items():
        if UP in pair:
            continue
        tilts = tuple(found.tilts[name] for name in sorted(pair) if name in found.tilts)
        most = sum(tilt.region[1] for tilt in tilts) + GIVE
        low, high = known.region
        if len(tilts) == 2 and most < low and high < 180.0 - most:
            yield pair, (known, *tilts)


def _searched(
    angles: dict[frozenset[str], _Known],
    names: list[str],
    reported: set[Place],
    effort: Effort,
) -> Iterator[Fault]:
    """Four faces and more, of which every three can be: their normals are searched for."""
    number = {name: i for i, name in enumerate(names)}
    pairs = {tuple(sorted(number[n] for n in pair)): pair for pair in angles}
    left = left_over({(a, b): angles[pair].region for (a, b), pair in pairs.items()})
    if not left or effort.steps <= 0:
        return
    used = sorted({i for pair in left for i in pair})
    place = {i: n for n, i in enumerate(used)}
    regions = tuple(((place[a], place[b]), region) for (a, b), region in sorted(left.items()))
    exist, steps = vectors_exist(len(used), regions)
    effort.steps -= steps
    if not exist:
        known = [replace(angles[pairs[pair]], sure=False) for pair in left]
        faces = [names[i] for i in used]
        message = f"no directions of {_listed(faces)} with such angles were found"
        yield from _fault(message, known, reported, ())


def _fault(
    message: str,
    known: "tuple[_Known, ...] | list[_Known]",
    reported: set[Place],
    faces: "frozenset[str] | tuple[str, ...]",
) -> Iterator[Fault]:
    claims = list(dict.fromkeys(c for k in known for c in k.claims))
    own = [c for c in claims if c.origin.own]
    if not own or any(c.place in reported for c in claims):
        return
    reported.update(c.place for c in claims)
    last = max(own, key=lambda c: c.node.span.start)
    source = last.origin.source
    others = [c for c in claims if c.place != last.place]
    if faces:
        message += f" ({_listed(sorted(faces))})"
    hint = f"see {quoted(others, last)}" if others else ""
    sure = all(k.sure for k in known) and not any(c.origin.if_known for c in claims)
    severity = Severity.ERROR if sure else Severity.WARNING
    yield Fault("impossible-angles", message, source, last.node.span, hint, severity)


def _listed(names: list[str]) -> str:
    shown = ["the way up" if n == UP else f"`{n[1:]}`" for n in names]
    return ", ".join(shown[:-1]) + f" and {shown[-1]}"


# ----------------------------------------------------------------- reading


def _angles_of(claims: Claims) -> _Angles:
    found = _Angles()
    for claim, sure in premises(claims):
        match claim.said:
            case ("opposite", frozenset() as pair):
                found.add(pair, (OPPOSED, 180.0), claim, sure)
            case ("upward" | "downward" as side, (str() as face,)):
                found.sides.setdefault(face, (side, claim, sure))
            case ("level" | "upright" as word, (str() as face,)) if _is_face(face, claims):
                found.add_tilt(face, _OF_UP[word], claim, sure)
        for bound in claim.bounds:
            _read_bound(bound.half, claim, sure, claims, found)
    return found


def _read_bound(rest: Linear, claim: Claim, sure: bool, claims: Claims, found: _Angles) -> None:
    if len(rest.terms) != 1:
        return
    ((atom, factor),) = rest.terms.items()
    limit = -rest.constant / factor
    region = (limit, 360.0) if factor > 0 else (0.0, limit)
    match atom:
        case ("angle", frozenset() as pair) if not any(_is_piece(each, claims) for each in pair):
            found.add(pair, region, claim, sure)
        case ("dihedral", frozenset() as pair):
            found.add_dihedral(pair, region, claim)
        case ("tilt", str() as face) if _is_face(face, claims):
            found.add_tilt(face, region, claim, sure)


def _is_piece(name: Hashable, claims: Claims) -> bool:
    """Whether a name is a piece: its direction has no sense, and that of a bar no side."""
    symbol = claims.scope.symbols.get(str(name)[1:])
    return isinstance(symbol, PartSymbol | SetSymbol) and symbol.kinds == PIECE


def _is_face(name: Hashable, claims: Claims) -> bool:
    """Whether a name is a face: the tilt of an edge is that of the edge itself."""
    symbol = claims.scope.symbols.get(str(name)[1:])
    if isinstance(symbol, PartSymbol | SetSymbol):
        return symbol.kinds == FACE
    return "." in str(name)
