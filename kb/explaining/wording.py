"""Relations and causes in words, for readers who do not program."""

import re
from collections.abc import Sequence

from facetlog.grammar.vocabulary import VOCABULARY
from facetlog.kb.engine.terms import Atom, Struct, Term, Var
from facetlog.perception.facts.fact_schema import FACT_SCHEMA
from facetlog.plurals import many

__all__ = [
    "CAUSES",
    "HOW_SEEN",
    "LOOKING_SETTLES_NOT",
    "UNSEEN",
    "add_article",
    "describe_cause",
    "describe_relation",
    "describe_unknown",
    "listed",
    "readable",
    "runs",
]

UNSEEN = "unseen"
"""Name in rules of a part of which no face was measured."""
HOW_SEEN = frozenset({"whole", "scanned"})
"""Relations that say how a thing was seen, not what it is."""

# Sentences for true and false. {0} is the first argument, {1} the second, {all} every one.
_RELATIONS: dict[str, tuple[str, str]] = {
    "measured": ("{0} was measured", "{0} was not measured, only completed from its neighbours"),
    "adjoins": ("{all} share an edge", "{all} share no edge"),
    "coplanar": ("{all} lie in one plane", "{all} do not lie in one plane"),
    "opposite": ("{all} face away from each other", "{all} do not face away from each other"),
    "convex": ("{all} bulge outwards where they meet", "{all} are hollow where they meet"),
    "concave": ("{all} are hollow where they meet", "{all} bulge outwards where they meet"),
    "upward": ("{0} faces up", "{0} does not face up"),
    "downward": ("{0} faces down", "{0} does not face down"),
    "share_corner": ("{all} meet at one corner", "{all} do not meet at one corner"),
    "bounds": ("{0} is a side of {1}", "{0} is no side of {1}"),
    "touches": ("{all} touch", "{all} do not touch"),
    "on_ground": ("{0} stands on the ground", "{0} does not reach the ground"),
    "at_rim": ("{0} stands at the rim of {1}", "{0} does not stand at the rim of {1}"),
    "joins": ("{all} touch", "{all} do not touch"),
    "carries": ("{0} carries {1}", "{0} does not carry {1}"),
    "hangs_from": ("{0} hangs from {1}", "{0} does not hang from {1}"),
    "in": ("{0} lies in {1}", "{0} does not lie in {1}"),
    "frames": ("{0} is at the rim of {1}", "{0} is not at the rim of {1}"),
    "beside": ("{0} stands beside {1}", "{0} does not stand beside {1}"),
    "inside": ("{0} is inside {1}", "{0} is not inside {1}"),
    "open_at_top": ("{0} is open at the top", "{0} is not open at the top"),
    "open_at_side": ("{0} is open at a side", "{0} is not open at a side"),
    "hollows_known": ("all hollows of {0} are known", "{0} may have more hollows"),
    "openings_known": ("all openings of {0} are known", "{0} may have more openings"),
    "whole": ("{0} is known from all sides", "{0} is not known from all sides"),
    "scanned": ("{0} was scanned from some sides", "{0} was not scanned from some sides"),
}

CAUSES = {
    "unseen": "a part that it needs was not seen",
    "up": "which way is up was not given",
    "scale": "the scale was not given",
}
"""Why a measure or relation is not known, by what the rules call it."""

_BY_ZERO = "it divides by 0"
LOOKING_SETTLES_NOT = frozenset({CAUSES["up"], CAUSES["scale"], _BY_ZERO})
"""Why a measure or relation is not known that another look would not make known."""

# One value of the members of a set.
_OF_SETS = {"sum", "mean", "lowest", "highest", "order"} | {
    f"{end}_{what}" for end in ("smallest", "largest") for what in ("gap", "spacing", "step")
}

# More groups than this are not named one by one.
COUNTED_NAMED = 8

_ABSENT = {
    **{kind.functor: kind.absent for kind in FACT_SCHEMA if kind.absent},
    "joins": "volume that is in no piece lies against both",
    "/": _BY_ZERO,  # what it divides is known
}
# Words whose absence is that of a fact of another name.
_SAME_AS = {
    "convex": "dihedral",
    "concave": "dihedral",
    "shared_length": "adjoins",
    "height": "top_of",
    "piece_beside": "beside",
    "piece_inside": "inside",
    **{
        f"{of}_{name}": f"{of}_heights"
        for of in ("piece", "opening")
        for name in ("height", "top_of", "bottom_of", "elevation")
    },
    **{
        f"piece_{word.name}": "piece_level"
        for word in VOCABULARY.values()
        if word.unknown_when.startswith(VOCABULARY["cover"].unknown_when)
    },
}


def describe_unknown(measure: Term, cause: str) -> str:
    """Return that a measure is not known; of an unseen face there is no more to say.

    >>> describe_unknown(Struct("tilt", (Atom("f1"),)), "up")
    'tilt(f1) is not known'
    """
    return "not known" if cause == UNSEEN else f"{readable(measure)} is not known"


def describe_relation(relation: Term, truth: str, cause: str = "none") -> str:
    """Return a relation that is true, false or unknown, as a clause.

    >>> describe_relation(Struct("adjoins", (Atom("f1"), Atom("f2"))), "false")
    'f1 and f2 share no edge'
    """
    if cause == UNSEEN:
        return describe_unknown(relation, cause)
    match relation:
        case Struct(name, args) if _strip_word_prefix(name) in _RELATIONS:
            faces = _names(args)
            true, false = _RELATIONS[_strip_word_prefix(name)]
            unknown = (
                false
                if name in ("openings_known", "hollows_known")
                else f"it is not known whether {true}"
            )
            form = {"true": true, "false": false}.get(truth, unknown)
            # A list of faces may be empty.
            return form.format(*faces, *("nothing",) * 2, all=listed(faces))
    text = readable(relation)
    return {"true": text, "false": f"not {text}"}.get(truth, f"{text} is not known")


def describe_cause(cause: str, about: Term) -> str:
    """Return why a measure or relation is not known, or an empty text.

    >>> describe_cause("unstated", Struct("dihedral", (Atom("f1"), Atom("f2"))))[:19]
    'they do not adjoin,'
    >>> describe_cause("unstated", Struct("/", (1.0, 0)))
    'it divides by 0'
    """
    if cause in CAUSES:
        return CAUSES[cause]
    if cause == "none" or not isinstance(about, Struct):
        return ""
    absent = _ABSENT.get(_SAME_AS.get(about.functor, about.functor), "no picture shows it")
    # Were up the cause, it would have been given as such.
    return absent.removeprefix("up is not known, or ")


def listed(names: Sequence[str]) -> str:
    """Return names joined as in a sentence.

    >>> listed(("f1", "f2", "f3")), listed(())
    ('f1, f2 and f3', 'nothing')
    """
    if len(names) < 2:
        return names[0] if names else "nothing"
    return f"{', '.join(names[:-1])} and {names[-1]}"


def add_article(noun: str) -> str:
    """Return a model's name with its article.

    >>> add_article("table"), add_article("armchair")
    ('a table', 'an armchair')
    """
    return f"{'an' if noun[:1] in 'aeiou' else 'a'} {noun}"


def _names(terms: Sequence[Term]) -> tuple[str, ...]:
    found: list[str] = []
    for term in terms:
        match term:
            case tuple():
                found.extend(_names(term))
            case _:
                found.append(readable(term))
    return tuple(found)


def readable(term: Term) -> str:
    """Return the term as a person writes it; what is counted is named as long as that can be read.

    >>> readable(Struct("at_least", (Struct("share", (Atom("f1"),)), 0.8)))
    'at_least(share(f1), 0.8)'
    >>> readable(Struct("piece_length", (Atom("p1"),)))
    'length(p1)'
    >>> readable(Struct("count", (((Atom("f9"), Atom("f10")), (Atom("f3"),)),)))
    'count of f9–f10 and f3'
    >>> readable(Struct("smallest_spacing", ((Atom("p9"), Atom("p10")),)))
    'smallest spacing of p9–p10'
    """
    match term:
        case Struct("+" | "-" | "*" | "/" as operator, (left, right)):
            return f"{_format_operand(left)}{operator}{_format_operand(right)}"
        case Struct("-", (inside,)):
            return f"-{_format_operand(inside)}"
        case Struct("count", (tuple(counted),)):
            return f"count of {_counted(counted)}"
        case Struct(functor, (tuple(items),)) if functor in _OF_SETS:
            return f"{functor.replace('_', ' ')} of {_format_members(items)}"
        case Struct(functor, args):
            return f"{_strip_word_prefix(functor)}({', '.join(map(readable, args))})"
        case ():
            return "none"
        case tuple():
            return ", ".join(
                "+".join(map(readable, item))
                if isinstance(item, tuple) and item
                else readable(item)
                for item in term
            )
        case Var():
            return "any"
        case Atom(name):
            return name
        case _:
            return str(term)


def _format_members(items: Sequence[Term]) -> str:
    """Return members of a set, or one measure of each of them, in short."""
    match items:
        case [Struct(functor, (Atom(),)), *_] if all(
            isinstance(item, Struct) and item.functor == functor and len(item.args) == 1
            for item in items
        ):
            members = [readable(arg) for item in items for arg in item.args]  # type: ignore[union-attr]
            return f"{_strip_word_prefix(functor)}({_shorten_members(members)})"
        case _ if all(isinstance(item, Atom) for item in items):
            return _shorten_members([readable(item) for item in items])
        case _:
            return readable(tuple(items))


NOUNS = {"f": "face", "e": "edge", "p": "piece", "o": "opening", "h": "hollow"}
"""Kinds of parts, by the letter that their names begin with."""
# More stretches of names that follow one another are counted.
STRETCHES_NAMED = 3


def count_members(names: Sequence[str]) -> str:
    """Return how many there are, as what their names say that they are.

    >>> count_members(["p1", "p4"]), count_members(["p1", "f4", "f5"])
    ('2 pieces', '3 elements')
    """
    nouns = {NOUNS.get(name[:1], "object") for name in names}
    return many(len(names), nouns.pop() if len(nouns) == 1 else "element")


def _shorten_members(names: Sequence[str]) -> str:
    short = runs(names, ", ")
    return count_members(names) if short.count(",") >= STRETCHES_NAMED else short


def _strip_word_prefix(functor: str) -> str:
    """Return the word as models write it: some have another name in Prolog."""
    return re.sub("^(piece|opening|thing)_", "", functor)


def _counted(items: Sequence[Term]) -> str:
    if len(items) > COUNTED_NAMED:
        return f"{len(items)} groups"
    return listed(tuple(runs(_names((item,))) for item in items))


def runs(names: Sequence[str], between: str = "+") -> str:
    """Return names in order, those that follow one another as one.

    >>> runs(("f9", "f2", "f8", "f10"))
    'f2+f8–f10'
    """
    split = (re.fullmatch(r"(.*?)(\d*)", name) for name in names)
    keys = sorted((m[1], int(m[2] or -1), m[0]) for m in split if m is not None)
    found: list[list[tuple[str, int, str]]] = []
    for key in keys:
        if found and found[-1][-1][:2] == (key[0], key[1] - 1):
            found[-1].append(key)
        else:
            found.append([key])
    return between.join(r[0][2] if len(r) == 1 else f"{r[0][2]}–{r[-1][2]}" for r in found)


def _format_operand(term: Term) -> str:
    # Inside another operation a sum needs its brackets.
    match term:
        case Struct("+" | "-", (_, _)):
            return f"({readable(term)})"
        case _:
            return readable(term)
