"""The forms that a search begins with: the builders of examples, and assemblies of a few parts."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from types import MappingProxyType

from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.built_solids import Solid, build_solids
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS
from facetlog.plurals import many
from facetlog.prototype.assembly import ZERO, Assembly, Form, Length, Part
from facetlog.prototype.patterns import PATTERNS, Extent, Plan, Sides, about, find_pattern, grids

# Of what comes in numbers: so many at most are tried.
COUNTS = (2, 3, 4, 5)
MOST_PARTS = 14
"""Of an assembly: things with more are no prototypes."""

# Sizes at which fitting begins, metres: of a piece of furniture, whatever it turns out to be.
LONG, WIDE, THIN, BAR, INSET, HIGH, WHEEL = 0.8, 0.5, 0.03, 0.045, 0.025, 0.4, 0.1
SUNK = 0.05
"""Of a wheel's height, so much lies within what it carries, or they would touch along a line."""


@dataclass(frozen=True, slots=True)
class BuilderForm:
    """A thing that examples of models are made of, with its lengths and angles free."""

    builder: str
    counts: Mapping[str, float] = field(default_factory=dict)

    @property
    def grows(self) -> bool:
        """Whether more parts can be added: its parts are not known here."""
        return False

    @property
    def name(self) -> str:
        """Its builder, as an example writes it."""
        counts = ", ".join(f"{name} {count:g}" for name, count in self.counts.items())
        return f"{self.builder}({counts})"

    @property
    def sizes(self) -> Mapping[str, float]:
        """Its usual sizes."""
        parameters = BUILDERS[self.builder].parameters
        return {p.name: p.default for p in parameters if p.kind != "count"}

    def scene(self, sizes: Mapping[str, float]) -> Scene:
        """Return what the builder makes of these sizes."""
        return build_solids([Solid(self.builder, {**self.counts, **sizes})])

    def described(self, sizes: Mapping[str, float]) -> str:
        """Return the builder and its sizes, as an example of a model writes them."""
        kinds = {p.name: p.kind for p in BUILDERS[self.builder].parameters}
        written = [f"{name} {count:g}" for name, count in self.counts.items()]
        for name, size in sizes.items():
            angle = kinds[name] == "angle"
            value, unit = (math.degrees(size), "deg") if angle else (100.0 * size, "cm")
            written.append(f"{name} {value:.3g} {unit}")
        return f"{self.builder}({', '.join(written)})"


def surfaces() -> Iterator[Form]:
    """Yield forms of which a part of the surface is there, and no solid."""
    yield from (BuilderForm(name) for name, builder in BUILDERS.items() if not builder.is_solid)


def iter_starting_forms(counts: Sequence[int] = COUNTS) -> Iterator[Form]:
    """Yield all that are solid, those of few parts first; of what comes in numbers so many."""
    for kind in ("block", "board", "upright board", "bar", "upright bar"):
        yield single(kind)
    for builder in filter(lambda each: each.is_solid, BUILDERS.values()):
        counted = [p.name for p in builder.parameters if p.kind == "count"]
        if not counted:
            yield BuilderForm(builder.name)
        for name in counted:
            for count in counts:
                yield BuilderForm(builder.name, {name: count})
    board, block = single("board"), single("block")
    for pattern in ("four legs", "two panels", "a column"):
        yield under(board, 0, pattern)
    for count in counts:
        for pattern in grids(count):
            yield under(board, 0, pattern, flush=True)
    for carried in (board, block):
        yield wheeled(carried)
    for pattern in ("four legs", "two panels"):
        angled = under(angle("board"), 0, pattern)
        yield under(angled, 1, pattern)
    for count in counts:
        yield planked(count)
    yield on_top(board, 0, "four walls", flush=True)
    yield on_top(board, 0, "three panels", flush=True)
    yield capped(on_top(board, 0, "three panels", flush=True), 1)
    yield under(block, 0, "a block")
    for flush in (True, False):
        yield on_top(block, 0, "a head", flush=flush)
        posts = on_top(single("bar"), 0, "two posts", flush=flush)
        yield capped(posts, 1)
        yield under(single("bar"), 0, "two posts", flush=flush)
    yield on_top(under(board, 0, "four legs"), 0, "a back", flush=True)
    for count in counts:
        panels = on_top(board, 0, "two panels")
        yield between(capped(panels, 1), 1, 2, count)
        yield between(pair("upright bar"), 0, 1, count)
    legs = under(board, 0, "four legs")
    for count in (1, 2, 3):
        yield between(legs, 1, 4, count)
    yield flanked(legs, 1, 4)
    gate = under(single("bar"), 0, "two posts")
    for kind, carried in product(HUNG, (gate, legs)):
        yield hung(carried, 0, kind)
    yield borne(hung(gate, 0, "bar", 2), 3, 4)
    for steps in (1, 2, 3):
        yield beside(block, 0, steps)


def iter_grown_forms(
    start: Form, sizes: Mapping[str, float], counts: Sequence[int] = COUNTS
) -> Iterator[Form]:
    """Yield what one more group of parts makes of an assembly of these sizes; of other forms
    nothing.

    Of what comes between two parts there are 1 or so many.
    """
    if not isinstance(start, Assembly):
        return
    form = replace(start, sizes=sizes)
    if not any(part.round for part in form.parts):
        yield wheeled(form)
    for first, second in _apart(form):
        for count in dict.fromkeys((1, *counts)):
            if len(form.parts) + count <= MOST_PARTS:
                yield between(form, first, second, count)
        yield between(form, first, second, 1, upright=True)
        if len(form.parts) + 4 <= MOST_PARTS:
            yield flanked(form, first, second)
        if _is_raised(form, first):
            yield borne(form, first, second)
    for part in _different(form):
        yield capped(form, part)
        yield capped(form, part, flush=False)
        for pattern, made in PATTERNS.items():
            if len(form.parts) + made.count > MOST_PARTS:
                continue
            for flush in (False, True):
                yield under(form, part, pattern, flush=flush)
                yield on_top(form, part, pattern, flush=flush)
        for steps in (1, 2):
            yield beside(form, part, steps)
        for kind in HUNG:
            yield attached(form, part, kind)
        for count in counts:
            for pattern in grids(count):
                if len(form.parts) + count <= MOST_PARTS:
                    yield under(form, part, pattern, flush=True)
        if _is_raised(form, part):
            for kind, count in product(HUNG, (1, 2)):
                if len(form.parts) + count <= MOST_PARTS:
                    yield hung(form, part, kind, count)


def _is_raised(form: Assembly, part: int) -> bool:
    """Return whether there is room between a part and the ground."""
    return bool(form.parts[part].z[0].terms)


def _at_heights(form: Assembly) -> list[list[int]]:
    """Return the parts at each height: what stands on or under another of them is alike."""
    found: dict[str, list[int]] = {}
    for index, part in enumerate(form.parts):
        key = repr([sorted(end.terms.items()) for end in part.z])
        found.setdefault(key, []).append(index)
    return list(found.values())


def _different(form: Assembly) -> list[int]:
    """Return one of all parts at each height."""
    return [some[0] for some in _at_heights(form)]


def _apart(form: Assembly) -> Iterator[tuple[int, int]]:
    """Yield at each height the first part and the last that is away from it along x."""
    for first, *others in _at_heights(form):
        end = form.parts[first].x[1].of(form.sizes)
        away = [other for other in others if form.parts[other].x[0].of(form.sizes) > end]
        if away:
            yield first, away[-1]


def single(kind: str) -> Assembly:
    """Return one level board, block or bar, or an upright board, on the ground."""
    extents = {
        "board": (LONG, WIDE, THIN),
        "block": (LONG, WIDE, HIGH),
        "bar": (LONG, BAR, BAR),
        "upright board": (LONG, THIN, HIGH),
        "upright bar": (BAR, BAR, LONG),
    }[kind]
    names = ("length", "depth", "height")
    x, y, z = ((ZERO, Length({name: 1.0})) for name in names)
    sizes = dict(zip(names, extents, strict=True))
    return Assembly(f"a {kind}", sizes, (Part(x, y, z),))


def pair(kind: str) -> Assembly:
    """Return two of the parts that `single` makes, apart along x: one solid once more is put to
    them.
    """
    one = single(kind)
    grown, apart = one.size("apart", HIGH)
    part = one.parts[0]
    away = part.x[1] + apart
    other = Part((part.x[0] + away, part.x[1] + away), part.y, part.z)
    return Assembly(f"two {kind}s", grown.sizes, (part, other))


def angle(kind: str) -> Assembly:
    """Return two of the parts that `single` makes at a right angle, as an L in plan."""
    one = single(kind)
    grown, wing = one.size("wing", WIDE)
    long = one.parts[0]
    other = Part((ZERO, long.y[1]), (long.y[1], long.y[1] + wing), long.z)
    return Assembly(f"two {kind}s at a right angle", grown.sizes, (long, other), joined=False)


def planked(count: int) -> Assembly:
    """Return so many level boards side by side across two long upright ones."""
    rail = single("upright board")
    grown, apart = rail.size("apart", HIGH)
    grown, wide = grown.size("width", LONG / (2 * count))
    grown, thick = grown.size("thickness", THIN)
    (long,) = rail.parts
    away = long.y[1] + apart
    other = replace(long, y=(away, away + long.y[1]))
    places = Sides(*long.x, ZERO, wide).spread(count)
    z = (long.z[1], long.z[1] + thick)
    planks = tuple(Part(x, (ZERO, other.y[1]), z) for x in places)
    name = f"{many(count, 'board')} across two upright ones"
    return Assembly(name, grown.sizes, (long, other, *planks))


def wheeled(start: Assembly) -> Assembly:
    """Return all of it on wheels: one under each part that stands on the ground, four under one
    that stands alone. Their tops reach a little into what they carry.
    """
    standing = [part for part in start.parts if not part.z[0].terms]
    grown, across = start.size("wheel", WHEEL)
    grown, thick = grown.size("tread", WHEEL / 3)
    grown = grown.raised(across * (1.0 - SUNK))
    wheels = []
    for part in standing:
        if len(standing) == 1:
            x, y = (
                Sides(*extent, ZERO, size) for extent, size in ((part.x, across), (part.y, thick))
            )
            plans = [(a, b) for a in (x.first, x.last) for b in (y.first, y.last)]
        else:
            plans = [
                (
                    about((part.x[0] + part.x[1]) * 0.5, across),
                    about((part.y[0] + part.y[1]) * 0.5, thick),
                )
            ]
        wheels += [Part(*plan, (ZERO, across), "wheel") for plan in plans]
    return grown.also(f"on {many(len(wheels), 'wheel')}", wheels)


def _sides(grown: Assembly, on: Part, pattern: str, *, flush: bool) -> tuple[Assembly, Plan, Plan]:
    made, rim = find_pattern(pattern), ZERO
    if not flush:
        grown, rim = grown.size("inset", INSET)
    start = BAR if made.kind == "bar" else THIN
    if made.longest_row:  # it begins half as wide as it could be
        shorter = min((high - low).of(grown.sizes) for low, high in (on.x, on.y))
        start = shorter / (2 * made.longest_row)
    grown, thick = grown.size("thickness", start)
    x, y = (Sides(*extent, rim, thick) for extent in (on.x, on.y))
    return grown, x, y  # type: ignore[return-value]


def _placed(
    grown: Assembly, on: Part, pattern: str, z: Extent, *, flush: bool
) -> tuple[Assembly, tuple[Part, ...]]:
    grown, x, y = _sides(grown, on, pattern, flush=flush)
    plans = find_pattern(pattern).plan(x, y)  # type: ignore[arg-type]
    return grown, tuple(Part(*plan, z) for plan in plans)


def under(start: Assembly, part: int, pattern: str, *, flush: bool = False) -> Assembly:
    """Return what carries a part: from the ground, above which all is raised if the part stands on
    it.
    """
    grown, on = start, start.parts[part]
    if not on.z[0].terms:
        grown, stand = grown.size("stand", HIGH)
        grown = grown.raised(stand)
        on = grown.parts[part]
    grown, placed = _placed(grown, on, pattern, (ZERO, on.z[0]), flush=flush)
    return grown.also(f"{pattern} under it", placed)


def on_top(start: Assembly, part: int, pattern: str, *, flush: bool = False) -> Assembly:
    """Return what stands on a part."""
    grown, rise = start.size("rise", HIGH)
    on = grown.parts[part]
    z = (on.z[1], on.z[1] + rise)
    grown, placed = _placed(grown, on, pattern, z, flush=flush)
    return grown.also(f"{pattern} on it", placed)


def capped(start: Assembly, carrier: int, *, plan: int = 0, flush: bool = True) -> Assembly:
    """Return a level board across on top of part `carrier`, over the plan of part `plan`."""
    grown, thick = start.size("thickness", THIN)
    out = ZERO
    if not flush:
        grown, out = grown.size("overhang", INSET)
    below, base = grown.parts[carrier], grown.parts[plan]
    z = (below.z[1], below.z[1] + thick)
    x, y = ((low - out, high + out) for low, high in (base.x, base.y))
    return grown.also("a board across on top", (Part(x, y, z),))


def between(
    start: Assembly, first: int, second: int, count: int, *, upright: bool = False
) -> Assembly:
    """Return so many level boards, evenly apart, or one upright board, from a part to one along x.

    They are as deep as both parts together, but for an inset, and shorter parts are bars.
    """
    a, b = start.parts[first], start.parts[second]
    x = (a.x[1], b.x[0])
    low, high = a.z
    # Of posts, which are thinner than boards are wide, no inset may leave nothing.
    deep = (b.y[1] - a.y[0]).of(start.sizes)
    grown, inset = start.size("inset", min(INSET, deep / 8))
    y = (a.y[0] + inset, b.y[1] - inset)
    rise = (high - low).of(start.sizes)
    grown, thick = grown.size("thickness", min(THIN, rise / (3 * count)))
    if upright:
        grown, drop = grown.size("drop", rise / 2)
        placed = [Part(x, (y[1] - thick, y[1]), (high - drop, high))]
        return grown.also("an upright board between", placed)
    # They begin evenly apart, from each other as from both ends.
    gap = (rise - count * min(THIN, rise / (3 * count))) / (count + 1)
    grown, foot = grown.size("below", gap)
    bottom, room = low + foot, ZERO
    if count > 1:
        grown, above = grown.size("above", gap)
        room = high - above - thick - bottom
    starts = [bottom + room * (i / max(1, count - 1)) for i in range(count)]
    placed = [Part(x, y, (z, z + thick)) for z in starts]
    return grown.also(f"{count} boards between", placed)


# Along x and y, of a piece that hangs: a part flush with what it hangs from would be one piece.
HUNG = MappingProxyType(
    {"bar": (THIN, THIN), "board": (HIGH / 2, THIN), "block": (HIGH / 4, HIGH / 4)}
)


def hung(start: Assembly, part: int, kind: str, count: int = 1) -> Assembly:
    """Return so many pieces evenly apart along x beneath a part, which end half way to the
    ground.
    """
    on = start.parts[part]
    grown, drop = start.size("drop", on.z[0].of(start.sizes) / 2)
    grown, wide = grown.size("width", HUNG[kind][0])
    grown, deep = grown.size("depth", HUNG[kind][1])
    y = about((on.y[0] + on.y[1]) * 0.5, deep)
    places = (on.x[0] + (on.x[1] - on.x[0]) * (nth / (count + 1)) for nth in range(1, count + 1))
    placed = [Part(about(x, wide), y, (on.z[0] - drop, on.z[0])) for x in places]
    return grown.also(f"{many(count, kind)} hanging from it", placed)


def attached(start: Assembly, part: int, kind: str) -> Assembly:
    """Return a piece against a part's side along x, half as high as that."""
    on = start.parts[part]
    grown, rise = start.size("height", (on.z[1] - on.z[0]).of(start.sizes) / 2)
    grown, wide = grown.size("width", HUNG[kind][0])
    grown, thick = grown.size("thickness", HUNG[kind][1])
    y = about((on.y[0] + on.y[1]) * 0.5, wide)
    placed = Part((on.x[1], on.x[1] + thick), y, (on.z[1] - rise, on.z[1]))
    return grown.also(f"a {kind} at its side", (placed,))


def borne(start: Assembly, first: int, second: int) -> Assembly:
    """Return a level board beneath two parts that end above the ground: a seat on ropes."""
    a, b = start.parts[first], start.parts[second]
    grown, thick = start.size("thickness", THIN)
    grown, out = grown.size("overhang", 2 * INSET)
    x, y = (a.x[0] - out, b.x[1] + out), (a.y[0] - out, b.y[1] + out)
    return grown.also("a board beneath", (Part(x, y, (a.z[0] - thick, a.z[0])),))


def flanked(start: Assembly, first: int, second: int) -> Assembly:
    """Return a level board along x on each side of two parts, on bars across that go
    through those.
    """
    a, b = start.parts[first], start.parts[second]
    grown, foot = start.size("rise", (a.z[1] - a.z[0]).of(start.sizes) / 2)
    grown, thick = grown.size("thickness", THIN)
    grown, wide = grown.size("width", HIGH / 2)
    grown, clear = grown.size("clear", HIGH / 4)
    ends = (a.y[0] - clear - wide, b.y[1] + clear + wide)
    on = a.z[0] + foot
    bars = [Part(part.x, ends, (on - thick, on)) for part in (a, b)]
    x, z = (a.x[0], b.x[1]), (on, on + thick)
    sides = ((ends[0], ends[0] + wide), (ends[1] - wide, ends[1]))
    return grown.also("a board on each side", (*bars, *(Part(x, y, z) for y in sides)))


def beside(start: Assembly, part: int, steps: int) -> Assembly:
    """Return so many blocks beside a part along x, each an equal step lower than the one before."""
    grown, going = start.size("going", HIGH / 2)
    on = grown.parts[part]
    placed = []
    for nth in range(1, steps + 1):
        x = (on.x[1] + going * (nth - 1.0), on.x[1] + going * float(nth))
        top = on.z[1] * ((steps + 1 - nth) / (steps + 1))
        placed.append(Part(x, on.y, (ZERO, top)))
    return grown.also(f"{steps} lower beside it", placed)
