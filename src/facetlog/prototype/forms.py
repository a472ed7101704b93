"""The forms that a search begins with: the builders of examples, and assemblies of a few parts."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.prototype.assembly import Assembly, Form
from facetlog.prototype.growth import (
    HUNG,
    PATTERNS,
    beside,
    between,
    borne,
    capped,
    flanked,
    hung,
    on_top,
    pair,
    single,
    under,
)

__all__ = ["COUNTS", "MOST_PARTS", "BuilderForm", "grown_from", "starting_forms", "surfaces"]

# Of what comes in numbers: so many at most are tried.
COUNTS = (2, 3, 4, 5)
MOST_PARTS = 14
"""Of an assembly: things with more are no prototypes."""


@dataclass(frozen=True, slots=True)
class BuilderForm:
    """A thing that examples of models are made of, with its lengths and angles free."""

    builder: str
    counts: Mapping[str, float] = field(default_factory=dict)

    @property
    def grows(self) -> bool:
        """No: its parts are not known here."""
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
        """What the builder makes of these sizes."""
        return build(self.builder, {**self.counts, **sizes})

    def described(self, sizes: Mapping[str, float]) -> str:
        """The builder and its sizes, as an example of a model writes them."""
        kinds = {p.name: p.kind for p in BUILDERS[self.builder].parameters}
        written = [f"{name} {count:g}" for name, count in self.counts.items()]
        for name, size in sizes.items():
            angle = kinds[name] == "angle"
            value, unit = (math.degrees(size), "deg") if angle else (100.0 * size, "cm")
            written.append(f"{name} {value:.3g} {unit}")
        return f"{self.builder}({', '.join(written)})"


def surfaces() -> Iterator[Form]:
    """Forms of which a part of the surface is there, and no solid."""
    yield from (BuilderForm(name) for name, builder in BUILDERS.items() if not builder.is_solid)


def starting_forms(counts: Sequence[int] = COUNTS) -> Iterator[Form]:
    """All that are solid, those of few parts first; of what comes in numbers so many."""
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
    yield on_top(board, 0, "four walls", flush=True)
    yield on_top(board, 0, "three panels", flush=True)
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


def grown_from(
    start: Form, sizes: Mapping[str, float], counts: Sequence[int] = COUNTS
) -> Iterator[Form]:
    """What one more group of parts makes of an assembly of these sizes; of other forms nothing.

    Of what comes between two parts there are 1 or so many.
    """
    if not isinstance(start, Assembly):
        return
    form = replace(start, sizes=sizes)
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
        if _is_raised(form, part):
            for kind, count in product(HUNG, (1, 2)):
                if len(form.parts) + count <= MOST_PARTS:
                    yield hung(form, part, kind, count)


def _is_raised(form: Assembly, part: int) -> bool:
    """Whether there is room between a part and the ground."""
    return bool(form.parts[part].z[0].terms)


def _at_heights(form: Assembly) -> list[list[int]]:
    """The parts at each height: what stands on or under another of them is alike."""
    found: dict[str, list[int]] = {}
    for index, part in enumerate(form.parts):
        key = repr([sorted(end.terms.items()) for end in part.z])
        found.setdefault(key, []).append(index)
    return list(found.values())


def _different(form: Assembly) -> list[int]:
    """One of all parts at each height."""
    return [some[0] for some in _at_heights(form)]


def _apart(form: Assembly) -> Iterator[tuple[int, int]]:
    """At each height the first part and the last that is away from it along x: the outermost."""
    for first, *others in _at_heights(form):
        end = form.parts[first].x[1].of(form.sizes)
        away = [other for other in others if form.parts[other].x[0].of(form.sizes) > end]
        if away:
            yield first, away[-1]
