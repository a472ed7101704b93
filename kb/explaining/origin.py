"""Where a name or fact of a scene comes from: down to vertices, and to pixels of pictures."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, TypeAlias

from facetlog.kb.explaining.amounts import (
    PERCENT,
    amount,
    deviation,
    format_lengths,
    format_with_unit,
    measured,
)
from facetlog.kb.explaining.measure_words import describe_ratio
from facetlog.kb.explaining.verdict_text import CERTAIN
from facetlog.perception.facts.fact_schema import FACT_KINDS, ArgumentKind, FactKind, Value

__all__ = [
    "EdgeOrigin",
    "FaceOrigin",
    "FactOrigin",
    "OpeningOrigin",
    "Origin",
    "PieceOrigin",
    "Plane",
    "Sighting",
    "ThingOrigin",
    "VertexOrigin",
    "ViewOrigin",
]

# Of a long list this many items are written unless all are asked for.
SHOWN = 3


@dataclass(frozen=True, slots=True)
class Sighting:
    """A pixel at which a picture shows a vertex: column and row with deviations, pixels."""

    view: str
    picture: str
    column_px: float
    row_px: float
    sd_column_px: float
    sd_row_px: float

    def __str__(self) -> str:
        column = measured(self.column_px, self.sd_column_px)
        row = measured(self.row_px, self.sd_row_px)
        spread = max(self.sd_column_px, self.sd_row_px)
        return f"{self.view} ({self.picture}): column {column}, row {row}, ± {spread:.2g} px"


@dataclass(frozen=True, slots=True)
class _Named:
    """An origin as Prolog writes it: a term with this functor and the fields as arguments."""

    functor: ClassVar[str]

    def to_json(self) -> dict[str, Any]:
        """Return the origin as plain data."""
        data = {"kind": self.functor, **asdict(self)}
        for name in ("faces", "edges"):
            items = [item for item in getattr(self, name, ()) if isinstance(item, _Named)]
            data |= {name: [item.to_json() for item in items]} if items else {}
        return data


@dataclass(frozen=True, slots=True)
class VertexOrigin(_Named):
    """A vertex: its place and deviations along x, y, z (length units), and who saw it."""

    functor: ClassVar[str] = "vertex"
    name: str
    position: tuple[float, float, float] | None
    sd: tuple[float, float, float] | None
    label: str | None
    sightings: tuple[Sighting, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the vertex, then a line for each picture that shows it; none of a mesh does."""
        label = f" ({self.label})" if self.label else ""
        yield f"{self.name}{label}{self._format_position(length_unit)}"
        shown = len(self.sightings) if full else SHOWN
        for sighting in self.sightings[:shown]:
            yield f"  seen in {sighting}"
        yield from _iter_rest_line(len(self.sightings) - shown, "view")

    def _format_position(self, length_unit: str | None) -> str:
        if self.position is None:
            return ""
        return f" at {format_lengths(self.position, max(self.sd or (0.0,)), length_unit or '')}"


@dataclass(frozen=True, slots=True)
class Plane:
    """Unit outward normal and offset, a x + b y + c z + d = 0; deviations in degrees and length."""

    normal: tuple[float, float, float]
    offset: float
    tilt_sd_deg: float | None
    offset_sd: float | None

    def text(self, length_unit: str | None) -> str:
        """Return the plane, its offset in a unit that suits."""
        normal = ", ".join(f"{x + 0.0:.3f}" for x in (round(x, 3) for x in self.normal))
        tilt = "" if self.tilt_sd_deg is None else f" ± {self.tilt_sd_deg:.2g}°"
        offset = format_lengths((self.offset,), self.offset_sd or 0.0, length_unit or "")
        return f"plane with outward normal ({normal}){tilt}, offset {offset}"


@dataclass(frozen=True, slots=True)
class FaceOrigin(_Named):
    """A face: its thing, evidence (measured or implied), plane, and vertices in order."""

    functor: ClassVar[str] = "face"
    name: str
    thing: str | None
    evidence: str | None
    plane: Plane | None
    corners: tuple[VertexOrigin, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the face, its plane, then its vertices."""
        said = [self.evidence or "of unknown evidence"]
        if self.thing:
            said.append(f"part of {self.thing}")
        yield f"{self.name}: a face, {', '.join(said)}, with {len(self.corners)} corners"
        if self.plane is not None:
            yield f"  {self.plane.text(length_unit)}"
        for corner in self.corners:
            yield from _indent_lines(corner.lines(full=full, length_unit=length_unit))


@dataclass(frozen=True, slots=True)
class EdgeOrigin(_Named):
    """An edge: evidence, length, the share found in the views, its two ends, its faces."""

    functor: ClassVar[str] = "edge"
    name: str
    evidence: str | None
    length: float | None
    length_sd: float | None
    support: float | None
    ends: tuple[VertexOrigin, ...]
    faces: tuple[str, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the edge, then its ends."""
        said = [self.evidence or "of unknown evidence"]
        if self.length is not None:
            length = format_lengths((self.length,), self.length_sd or 0.0, length_unit or "")
            said.append(f"{length} long")
        if self.support is not None:
            said.append(f"{self.support:.0%} of it found in the views")
        if self.faces:
            said.append(f"side of {', '.join(self.faces)}")
        yield f"{self.name}: an edge, {', '.join(said)}"
        for end in self.ends:
            yield from _indent_lines(end.lines(full=full, length_unit=length_unit))


@dataclass(frozen=True, slots=True)
class PieceShare:
    """A side of a piece as a share of another, and the limit between two shapes."""

    measure: str
    value: float
    limit: float


@dataclass(frozen=True, slots=True)
class PieceShape:
    """Board, bar or block, how surely, and the shares that this rests on."""

    name: str
    degree: float
    shares: tuple[PieceShare, ...]

    def __str__(self) -> str:
        nearest = min(self.shares, key=lambda share: abs(share.value - share.limit))
        side, whole = (re.sub(r"\(\w+\)", "", text) for text in describe_ratio(nearest.measure))
        share, limit = (f"{amount(PERCENT.of(x))} %" for x in (nearest.value, nearest.limit))
        sure = "" if self.degree >= CERTAIN else f" to {self.degree:.0%}"
        return f"a {self.name}{sure} ({side} {share}{whole}, limit {limit})"


@dataclass(frozen=True, slots=True)
class PieceOrigin(_Named):
    """A piece: its thing, the sides of its least box, longest first, and the faces of its own.

    `heights` are from where to where it reaches above its thing's lowest point, and their
    deviation; None where up is not known. `curved_share` is how much of its surface is curved.
    """

    functor: ClassVar[str] = "piece"
    name: str
    thing: str | None
    size: tuple[float, float, float]
    size_sd: float
    heights: tuple[float, float, float] | None
    is_measured: bool
    curved_share: float
    faces: tuple[FaceOrigin, ...]
    shape: PieceShape | None = None

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the piece, then its faces; of one without a face that it is curved all over."""
        said = ["measured" if self.is_measured else "implied"]
        if self.thing:
            said.append(f"part of {self.thing}")
        said.append(format_lengths(self.size, self.size_sd, length_unit or "", sign=" × "))
        said += _iter_height_texts(self.heights, length_unit)
        if self.curved_share > 0.0:
            said.append(f"{self.curved_share:.0%} of its surface curved")
        yield f"{self.name}: {self.shape or 'a piece'}, {', '.join(said)}"
        yield from _iter_item_lines(self.faces, "face", full=full, length_unit=length_unit)


@dataclass(frozen=True, slots=True)
class OpeningOrigin(_Named):
    """An opening or hollow: its thing, length and width of it, and what is round it.

    `heights` as of a piece; `pieces` are along its rim, and it is in `faces`.
    """

    functor: ClassVar[str] = "opening"
    name: str
    kind: str
    thing: str | None
    size: tuple[float, float]
    size_sd: float
    heights: tuple[float, float, float] | None
    pieces: tuple[str, ...]
    faces: tuple[FaceOrigin, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the opening with what frames it, then the faces that it is in."""
        article, where = ("an", "through") if self.kind == "opening" else ("a", "in")
        said = [f"{where} {self.thing}"] if self.thing else []
        said.append(format_lengths(self.size, self.size_sd, length_unit or "", sign=" × "))
        said += _iter_height_texts(self.heights, length_unit)
        if self.pieces:
            said.append(f"framed by {', '.join(self.pieces)}")
        yield f"{self.name}: {article} {self.kind}, {', '.join(said)}"
        yield from _iter_item_lines(self.faces, "face", full=full, length_unit=length_unit)


@dataclass(frozen=True, slots=True)
class ThingOrigin(_Named):
    """A thing: the sides of its least box, longest first, its faces and its loose edges."""

    functor: ClassVar[str] = "thing"
    name: str
    size: tuple[float, float, float] | None
    faces: tuple[FaceOrigin, ...]
    edges: tuple[EdgeOrigin, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the thing, then its faces and loose edges."""
        size = ""
        if self.size is not None:
            size = f", {format_lengths(self.size, 0.0, length_unit or '', sign=' × ')}"
        loose = f" and {_count(len(self.edges), 'loose edge')}" if self.edges else ""
        yield f"{self.name}: a thing of {_count(len(self.faces), 'face')}{loose}{size}"
        yield from _iter_item_lines(self.faces, "face", full=full, length_unit=length_unit)
        yield from _iter_item_lines(self.edges, "loose edge", full=full, length_unit=length_unit)


@dataclass(frozen=True, slots=True)
class ViewOrigin(_Named):
    """A picture and the vertices that it shows."""

    functor: ClassVar[str] = "view"
    name: str
    picture: str
    vertices: tuple[str, ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the picture, then what it shows; nothing of it is a length."""
        del length_unit
        yield f"{self.name}: the picture {self.picture}, which shows {len(self.vertices)} vertices"
        shown = len(self.vertices) if full else 4 * SHOWN
        if self.vertices:
            yield f"  {', '.join(self.vertices[:shown])}"
        yield from _iter_rest_line(len(self.vertices) - shown, "vertex", "vertices")


@dataclass(frozen=True, slots=True)
class FactOrigin(_Named):
    """Facts of one functor, each its name and arguments, and the origins of what they name."""

    functor: ClassVar[str] = "facts"
    facts: tuple[tuple[str, tuple[Value, ...]], ...]
    of: tuple["Origin", ...]

    def lines(self, *, full: bool = False, length_unit: str | None = None) -> Iterator[str]:
        """Return the facts, then what they name."""
        shown = len(self.facts) if full else SHOWN
        yield from (_format_fact(*fact, length_unit) for fact in self.facts[:shown])
        yield from _iter_rest_line(len(self.facts) - shown, "fact")
        named = len(self.of) if full else SHOWN
        for origin in self.of[:named]:
            yield from _indent_lines(origin.lines(full=full, length_unit=length_unit))
        yield from _iter_rest_line(len(self.of) - named, "name")

    def to_json(self) -> dict[str, Any]:
        """Return the origin as plain data."""
        return {
            "kind": self.functor,
            "facts": [f"{name}({', '.join(map(str, args))})" for name, args in self.facts],
            "of": [origin.to_json() for origin in self.of],
        }


Origin: TypeAlias = (
    VertexOrigin
    | FaceOrigin
    | EdgeOrigin
    | PieceOrigin
    | OpeningOrigin
    | ThingOrigin
    | ViewOrigin
    | FactOrigin
)
"""Where something of a scene comes from; each has lines() and to_json()."""


def _iter_item_lines(
    items: Sequence[FaceOrigin | EdgeOrigin], noun: str, *, full: bool, length_unit: str | None
) -> Iterator[str]:
    """Return the first of some faces or edges, indented, and how many more there are."""
    shown = len(items) if full else SHOWN
    for item in items[:shown]:
        yield from _indent_lines(item.lines(full=full, length_unit=length_unit))
    yield from _iter_rest_line(len(items) - shown, noun)


def _iter_height_texts(
    heights: tuple[float, float, float] | None, length_unit: str | None
) -> Iterator[str]:
    """Yield from where to where something is above its thing's lowest point, if that is known."""
    if heights is not None:
        low, high, sd = heights
        yield f"{format_lengths((low, high), sd, length_unit or '', sign=' to ')} up"


def _indent_lines(lines: Iterator[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)


def _count(count: int, noun: str) -> str:
    return f"{count} {noun if count == 1 else f'{noun}s'}"


def _iter_rest_line(count: int, noun: str, plural: str = "") -> Iterator[str]:
    if count > 0:
        yield f"  and {count} more {noun if count == 1 else plural or noun + 's'}"


_UNITS = {ArgumentKind.DEGREES: "°", ArgumentKind.PIXELS: "px"}


def _format_fact(functor: str, args: Sequence[Value], length_unit: str | None) -> str:
    """Return the fact in words; as a term where the schema does not have it.

    >>> _format_fact("elevation", ("f1", 0.15232, 3.95e-05), "m")
    'elevation(f1) = 152.3 ± 0.04 mm'
    >>> _format_fact("thing_size", ("t1", 0.2541, 0.2034, 0.15), "m")
    'thing_size(t1): L = 25.41 cm, W = 20.34 cm, H = 15 cm'
    >>> _format_fact("convex", ("f1", "f2"), "m")
    'convex(f1, f2)'
    """
    kind = FACT_KINDS.get(functor)
    if kind is None or kind.arity != len(args):
        return f"{functor}({', '.join(map(str, args))})"
    about = f"{functor}({', '.join(map(str, args[: kind.keys]))})"
    values = list(_iter_values(kind, args, length_unit))
    if len(values) == 1:
        return f"{about} = {values[0][1]}"
    said = ", ".join(f"{name} = {text}" for name, text in values)
    return f"{about}: {said}" if said else about


def _iter_values(
    kind: FactKind, args: Sequence[Value], length_unit: str | None
) -> Iterator[tuple[str, str]]:
    """Return the values behind the keys by their names, each with its deviation."""
    names = [argument.name for argument in kind.arguments]
    for place in range(kind.keys, kind.arity):
        argument, value = kind.arguments[place], args[place]
        if argument.name.startswith("Sd") and place > kind.keys:
            continue
        own = f"Sd{argument.name}"
        following = place + 1 < kind.arity and names[place + 1] == "Sd"
        spread = args[names.index(own)] if own in names else args[place + 1] if following else 0.0
        yield argument.name, _format_value(argument.kind, value, spread, length_unit)


def _format_value(kind: ArgumentKind, value: Value, spread: Value, length_unit: str | None) -> str:
    if isinstance(value, str) or isinstance(spread, str):
        return str(value)
    if kind in (ArgumentKind.LENGTH, ArgumentKind.AREA):
        square = "²" if kind is ArgumentKind.AREA else ""
        return format_lengths((value,), spread, f"{length_unit}{square}" if length_unit else "")
    unit = _UNITS.get(kind, "")
    said = deviation(value, spread)
    number = measured(value, spread) if said else amount(value)
    return f"{format_with_unit(number, unit)}{f' ± {format_with_unit(said, unit)}' if said else ''}"
