"""Prolog's origins, as origin.pl says them, as Origin."""

import math

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.origin import (
    EdgeOrigin,
    FaceOrigin,
    FactOrigin,
    OpeningOrigin,
    Origin,
    PieceOrigin,
    Plane,
    Sighting,
    ThingOrigin,
    VertexOrigin,
    ViewOrigin,
)
from facetlog.kb.explaining.wording import readable
from facetlog.perception.facts.fact_schema import Value

__all__ = ["decode_origin"]


def decode_origin(term: Term) -> Origin:
    """The origin that origin/2 of origin.pl says. Raises EngineError if it cannot be read."""
    match term:
        case Struct("vertex"):
            return _vertex(term)
        case Struct("face"):
            return _face(term)
        case Struct("edge"):
            return _edge(term)
        case Struct("thing", (Atom(name), tuple(sizes), tuple(faces), tuple(edges))):
            return ThingOrigin(
                name, _three(sizes), tuple(map(_face, faces)), tuple(map(_edge, edges))
            )
        case Struct("piece"):
            return _piece(term)
        case Struct("opening"):
            return _opening(term)
        case Struct("view", (Atom(name), (picture,), tuple(vertices))):
            return ViewOrigin(name, readable(picture), tuple(map(readable, vertices)))
        case Struct("facts", (tuple(facts), tuple(origins))):
            return FactOrigin(tuple(map(_fact, facts)), tuple(map(decode_origin, origins)))
    raise _unreadable(term)


def _fact(term: Term) -> tuple[str, tuple[Value, ...]]:
    match term:
        case Struct(name, args):
            numbers = (int, float)
            return name, tuple(a if isinstance(a, numbers) else readable(a) for a in args)
    raise _unreadable(term)


def _vertex(term: Term) -> VertexOrigin:
    match term:
        case Struct(
            "vertex",
            (Atom(name), tuple(places), tuple(covariances), tuple(labels), tuple(sightings)),
        ):
            return VertexOrigin(
                name=name,
                position=_three(places),
                sd=_deviations(covariances),
                label=_first(labels),
                sightings=tuple(map(_sighting, sightings)),
            )
    raise _unreadable(term)


def _sighting(term: Term) -> Sighting:
    match term:
        case Struct("seen", (view, picture, *numbers)) if len(numbers) == 4:
            return Sighting(readable(view), readable(picture), *map(_number, numbers))
    raise _unreadable(term)


def _face(term: Term) -> FaceOrigin:
    match term:
        case Struct(
            "face",
            (Atom(name), tuple(things), tuple(evidence), tuple(planes), tuple(sds), tuple(corners)),
        ):
            return FaceOrigin(
                name=name,
                thing=_first(things),
                evidence=_first(evidence),
                plane=_plane(planes, sds),
                corners=tuple(map(_vertex, corners)),
            )
    raise _unreadable(term)


def _piece(term: Term) -> PieceOrigin:
    match term:
        case Struct(
            "piece",
            (
                Atom(name),
                tuple(things),
                (Struct("size", (*lengths, sd)),),
                tuple(heights),
                tuple(measured),
                (curved,),
                tuple(faces),
            ),
        ) if len(lengths) == 3:
            longest, middle, least = map(_number, lengths)
            return PieceOrigin(
                name=name,
                thing=_first(things),
                size=(longest, middle, least),
                size_sd=_number(sd),
                heights=_three(heights),
                is_measured=bool(measured),
                curved_share=_number(curved),
                faces=tuple(map(_face, faces)),
            )
    raise _unreadable(term)


def _opening(term: Term) -> OpeningOrigin:
    match term:
        case Struct(
            "opening",
            (
                Atom(name),
                tuple(things),
                (Struct("size", (length, width, sd)),),
                tuple(heights),
                tuple(pieces),
                tuple(faces),
            ),
        ):
            return OpeningOrigin(
                name=name,
                thing=_first(things),
                size=(_number(length), _number(width)),
                size_sd=_number(sd),
                heights=_three(heights),
                pieces=tuple(map(readable, pieces)),
                faces=tuple(map(_face, faces)),
            )
    raise _unreadable(term)


def _plane(planes: tuple[Term, ...], sds: tuple[Term, ...]) -> Plane | None:
    match planes, sds:
        case (), _:
            return None
        case (Struct("plane", (a, b, c, d)), *_), ():
            return Plane((_number(a), _number(b), _number(c)), _number(d), None, None)
        case (Struct("plane", (a, b, c, d)), *_), (Struct("sd", (tilt, offset)), *_):
            normal = (_number(a), _number(b), _number(c))
            return Plane(normal, _number(d), _number(tilt), _number(offset))
    raise _unreadable(planes)


def _edge(term: Term) -> EdgeOrigin:
    match term:
        case Struct(
            "edge",
            (
                Atom(name),
                tuple(evidence),
                tuple(lengths),
                tuple(supports),
                tuple(ends),
                tuple(faces),
            ),
        ):
            length = sd = None
            if lengths:
                length, sd = _pair(lengths[0])
            return EdgeOrigin(
                name=name,
                evidence=_first(evidence),
                length=length,
                length_sd=sd,
                support=_number(supports[0]) if supports else None,
                ends=tuple(map(_vertex, ends)),
                faces=tuple(map(readable, faces)),
            )
    raise _unreadable(term)


def _pair(term: Term) -> tuple[float, float]:
    match term:
        case Struct(_, (first, second)):
            return _number(first), _number(second)
    raise _unreadable(term)


def _three(terms: tuple[Term, ...]) -> tuple[float, float, float] | None:
    match terms:
        case ():
            return None
        case (Struct(_, (x, y, z)), *_):
            return _number(x), _number(y), _number(z)
    raise _unreadable(terms)


def _deviations(terms: tuple[Term, ...]) -> tuple[float, float, float] | None:
    """Roots of the covariance's diagonal; rounding may leave a variance just below 0."""
    match terms:
        case ():
            return None
        case (Struct("cov", (xx, _, _, yy, _, zz)), *_):
            x, y, z = (math.sqrt(max(0.0, _number(v))) for v in (xx, yy, zz))
            return x, y, z
    raise _unreadable(terms)


def _first(terms: tuple[Term, ...]) -> str | None:
    return readable(terms[0]) if terms else None


def _number(term: Term) -> float:
    if isinstance(term, int | float):
        return float(term)
    raise _unreadable(term)


def _unreadable(term: Term) -> EngineError:
    return EngineError(f"Prolog's origin cannot be read: {readable(term)[:80]}")
