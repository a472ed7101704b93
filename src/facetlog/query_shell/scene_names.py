"""The names in a scene that a user may type, by kind."""

import re
from collections.abc import Mapping, Sequence

from facetlog.kb.engine.terms import Atom
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.fact_schema import ArgumentKind

# The fact that says that there is one, asked with N for its name.
_GOALS = {
    ArgumentKind.FACE: "face(N)",
    ArgumentKind.EDGE: "edge(N, _, _)",
    ArgumentKind.VERTEX: "vertex(N)",
    ArgumentKind.THING: "thing(N)",
    ArgumentKind.PIECE: "piece(N)",
    ArgumentKind.OPENING: "opening(N)",
    ArgumentKind.HOLLOW: "hollow_of(N, _)",
    ArgumentKind.VIEW: "view(N, _)",
}
_MIXED = {
    ArgumentKind.PART: (ArgumentKind.FACE, ArgumentKind.EDGE),
    ArgumentKind.LEVEL: (ArgumentKind.FACE, ArgumentKind.PIECE),
    ArgumentKind.HOLE: (ArgumentKind.OPENING, ArgumentKind.HOLLOW),
    ArgumentKind.SOLID: (ArgumentKind.PIECE, ArgumentKind.OPENING, ArgumentKind.HOLLOW),
    ArgumentKind.BODY: (ArgumentKind.FACE, ArgumentKind.EDGE, ArgumentKind.THING),
}


def scene_names(
    base: KnowledgeBase, scenes: Sequence[str]
) -> Mapping[ArgumentKind, tuple[str, ...]]:
    """Return the names of each kind in these scenes, in natural order (f2 before f10)."""
    found: dict[ArgumentKind, tuple[str, ...]] = {}
    for kind, goal in _GOALS.items():
        with base.query(goal, scenes=tuple(scenes)) as answers:
            names = {row[-1].name for row in answers if isinstance(row[-1], Atom)}
        found[kind] = tuple(sorted(names, key=_make_sort_key))
    return found


def list_names_of_kind(
    names: Mapping[ArgumentKind, tuple[str, ...]], kind: ArgumentKind
) -> tuple[str, ...]:
    """Return the names that an argument of this kind may have; a mixed kind has those of all its
    kinds.
    """
    return tuple(name for one in _MIXED.get(kind, (kind,)) for name in names.get(one, ()))


def kind_of(names: Mapping[ArgumentKind, Sequence[str]], name: str) -> ArgumentKind | None:
    """Return the kind of a name, or None if there is nothing of that name."""
    return next((kind for kind, those in names.items() if name in those), None)


def _make_sort_key(name: str) -> tuple[tuple[bool, int, str], ...]:
    pieces = re.findall(r"\d+|\D+", name)
    return tuple((p.isdecimal(), int(p) if p.isdecimal() else 0, p) for p in pieces)
