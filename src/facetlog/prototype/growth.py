"""How assemblies grow: what is put under, on, between and beside the parts, and hangs from them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from facetlog.counted import many
from facetlog.prototype.assembly import ZERO, Assembly, Length, Part

__all__ = [
    "HUNG",
    "PATTERNS",
    "Pattern",
    "beside",
    "between",
    "borne",
    "capped",
    "flanked",
    "hung",
    "on_top",
    "pair",
    "single",
    "under",
]

# Sizes at which fitting begins, metres: of a piece of furniture, whatever it turns out to be.
LONG, WIDE, THIN, BAR, INSET, HIGH = 0.8, 0.5, 0.03, 0.045, 0.025, 0.4

Extent = tuple[Length, Length]
Plan = tuple[Extent, Extent]


@dataclass(frozen=True, slots=True)
class _Sides:
    """An extent cut from both of its ends: `rim` in from them, and members so thick there."""

    low: Length
    high: Length
    rim: Length
    thick: Length

    @property
    def first(self) -> Extent:
        return self.low + self.rim, self.low + self.rim + self.thick

    @property
    def last(self) -> Extent:
        return self.high - self.rim - self.thick, self.high - self.rim

    @property
    def middle(self) -> Extent:
        return _about((self.low + self.high) * 0.5, self.thick)

    @property
    def inner(self) -> Extent:
        return self.first[1], self.last[0]

    @property
    def all(self) -> Extent:
        return self.low + self.rim, self.high - self.rim


@dataclass(frozen=True, slots=True)
class Pattern:
    """Where parts stand in a plan, how many there are, and of which kind they are."""

    count: int
    kind: str
    plan: Callable[[_Sides, _Sides], tuple[Plan, ...]]


PATTERNS: Mapping[str, Pattern] = MappingProxyType(
    {
        "four legs": Pattern(
            4,
            "bar",
            lambda x, y: tuple((a, b) for a in (x.first, x.last) for b in (y.first, y.last)),
        ),
        "three legs": Pattern(
            3, "bar", lambda x, y: ((x.first, y.first), (x.last, y.first), (x.middle, y.last))
        ),
        "two posts": Pattern(2, "bar", lambda x, y: ((x.first, y.middle), (x.last, y.middle))),
        "two panels": Pattern(2, "board", lambda x, y: ((x.first, y.all), (x.last, y.all))),
        "two long panels": Pattern(2, "board", lambda x, y: ((x.all, y.first), (x.all, y.last))),
        "three panels": Pattern(
            3, "board", lambda x, y: ((x.first, y.all), (x.last, y.all), (x.inner, y.last))
        ),
        "four walls": Pattern(
            4,
            "board",
            lambda x, y: (
                (x.first, y.all), (x.last, y.all), (x.inner, y.first), (x.inner, y.last)
            ),
        ),
        "a column": Pattern(1, "bar", lambda x, y: ((x.middle, y.middle),)),
        "a back": Pattern(1, "board", lambda x, y: ((x.all, y.last),)),
        "a head": Pattern(1, "board", lambda x, y: ((x.last, y.all),)),
        "a block": Pattern(1, "block", lambda x, y: ((x.all, y.all),)),
    }
)  # fmt: skip
"""By what they are called where a prototype is described."""


def single(kind: str) -> Assembly:
    """One level board, block or bar, or an upright board, on the ground."""
    extents = {
        "board": (LONG, WIDE, THIN),
        "block": (LONG, WIDE, HIGH),
        "bar": (LONG, BAR, BAR),
        "upright board": (LONG, THIN, HIGH),
        "upright bar": (BAR, BAR, LONG),
    }[kind]
    names = ("length", "depth", "height")
    ends = tuple((ZERO, Length({name: 1.0})) for name in names)
    sizes = dict(zip(names, extents, strict=True))
    return Assembly(f"a {kind}", sizes, (Part(*ends),))


def pair(kind: str) -> Assembly:
    """Two of the parts that `single` makes, apart along x: one solid once more is put to them."""
    one = single(kind)
    grown, apart = one.size("apart", HIGH)
    part = one.parts[0]
    away = part.x[1] + apart
    other = Part((part.x[0] + away, part.x[1] + away), part.y, part.z)
    return Assembly(f"two {kind}s", grown.sizes, (part, other))


def _sides(grown: Assembly, on: Part, pattern: str, *, flush: bool) -> tuple[Assembly, Plan, Plan]:
    kind = PATTERNS[pattern].kind
    rim = ZERO
    if not flush:
        grown, rim = grown.size("inset", INSET)
    grown, thick = grown.size("thickness", BAR if kind == "bar" else THIN)
    x, y = (_Sides(*extent, rim, thick) for extent in (on.x, on.y))
    return grown, x, y  # type: ignore[return-value]


def _placed(
    grown: Assembly, on: Part, pattern: str, z: Extent, *, flush: bool
) -> tuple[Assembly, tuple[Part, ...]]:
    grown, x, y = _sides(grown, on, pattern, flush=flush)
    plans = PATTERNS[pattern].plan(x, y)  # type: ignore[arg-type]
    return grown, tuple(Part(*plan, z) for plan in plans)


def under(start: Assembly, part: int, pattern: str, *, flush: bool = False) -> Assembly:
    """What carries a part: from the ground, above which all is raised if the part stands on it."""
    grown, on = start, start.parts[part]
    if not on.z[0].terms:
        grown, stand = grown.size("stand", HIGH)
        grown = grown.raised(stand)
        on = grown.parts[part]
    grown, placed = _placed(grown, on, pattern, (ZERO, on.z[0]), flush=flush)
    return grown.also(f"{pattern} under it", placed)


def on_top(start: Assembly, part: int, pattern: str, *, flush: bool = False) -> Assembly:
    """What stands on a part."""
    grown, rise = start.size("rise", HIGH)
    on = grown.parts[part]
    z = (on.z[1], on.z[1] + rise)
    grown, placed = _placed(grown, on, pattern, z, flush=flush)
    return grown.also(f"{pattern} on it", placed)


def capped(start: Assembly, carrier: int, *, plan: int = 0, flush: bool = True) -> Assembly:
    """A level board across on top of part `carrier`, over the plan of part `plan`."""
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
    """So many level boards, evenly apart, or one upright board, from a part to one along x.

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
    """So many pieces evenly apart along x beneath a part, which end half way to the ground."""
    on = start.parts[part]
    grown, drop = start.size("drop", on.z[0].of(start.sizes) / 2)
    grown, wide = grown.size("width", HUNG[kind][0])
    grown, deep = grown.size("depth", HUNG[kind][1])
    y = _about((on.y[0] + on.y[1]) * 0.5, deep)
    places = (on.x[0] + (on.x[1] - on.x[0]) * (nth / (count + 1)) for nth in range(1, count + 1))
    placed = [Part(_about(x, wide), y, (on.z[0] - drop, on.z[0])) for x in places]
    return grown.also(f"{many(count, kind)} hanging from it", placed)


def borne(start: Assembly, first: int, second: int) -> Assembly:
    """A level board beneath two parts that end above the ground: a seat on ropes."""
    a, b = start.parts[first], start.parts[second]
    grown, thick = start.size("thickness", THIN)
    grown, out = grown.size("overhang", 2 * INSET)
    x, y = (a.x[0] - out, b.x[1] + out), (a.y[0] - out, b.y[1] + out)
    return grown.also("a board beneath", (Part(x, y, (a.z[0] - thick, a.z[0])),))


def _about(middle: Length, extent: Length) -> Extent:
    return middle - extent * 0.5, middle + extent * 0.5


def flanked(start: Assembly, first: int, second: int) -> Assembly:
    """A level board along x on each side of two parts, on bars across that go through those."""
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
    """So many blocks beside a part along x, each an equal step lower than the one before."""
    grown, going = start.size("going", HIGH / 2)
    on = grown.parts[part]
    placed = []
    for nth in range(1, steps + 1):
        x = (on.x[1] + going * (nth - 1.0), on.x[1] + going * float(nth))
        top = on.z[1] * ((steps + 1 - nth) / (steps + 1))
        placed.append(Part(x, on.y, (ZERO, top)))
    return grown.also(f"{steps} lower beside it", placed)
