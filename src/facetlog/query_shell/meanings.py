"""The meanings of a goal's variables: kind, unit, and whose standard deviation.

Found by looking at which argument of which fact a variable is.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from facetlog.perception.facts.fact_schema import (
    FACT_KINDS,
    FACT_SCHEMA,
    Argument,
    ArgumentKind,
)
from facetlog.query_shell.goal_text import Call, Token, TokenKind, calls, tokens

# measure(Measure, Value, Sd, Kind) of the vocabulary: the place of value and deviation.
_MEASURE = ("measure", 4)


# Values that a reader takes for the height of the same thing, and that differ: fact and argument.
_HEIGHTS = frozenset(
    (functor, "H") for functor in ("elevation", "top_of", "bottom_of", "thing_size")
)


@dataclass(frozen=True, slots=True)
class Meaning:
    """Meaning of a variable; `sd` is the variable with its standard deviation, if any.

    `height` is the fact whose height it is, of which there are several.
    """

    kind: ArgumentKind
    sd: str | None = None
    is_sd: bool = False
    height: str = ""


def meanings(goal: str) -> dict[str, Meaning]:
    """Return the meaning of each variable that is an argument of a fact or the value of a measure.

    A variable that stands for different kinds has none.

    >>> meanings("angle(A, f2, Deg, Sd), Deg > 80")["Deg"]
    Meaning(kind=<ArgumentKind.DEGREES: 'deg'>, sd='Sd', is_sd=False, height='')
    """
    found: dict[str, Meaning] = {}
    doubtful = set()
    for call in calls(goal):
        for name, meaning in _iter_meanings(call):
            before = found.setdefault(name, meaning)
            if before.kind is not meaning.kind:
                doubtful.add(name)
            elif before.sd is None and meaning.sd is not None:
                found[name] = meaning
    return {name: meaning for name, meaning in found.items() if name not in doubtful}


def _iter_meanings(call: Call) -> Iterator[tuple[str, Meaning]]:
    names = [_find_variable(argument) for argument in call.arguments]
    kind = FACT_KINDS.get(call.functor)
    if kind is not None and kind.arity == len(names):
        sds = _pair_deviations(kind.arguments)
        deviating = set(sds.values())
        for i, (argument, name) in enumerate(zip(kind.arguments, names, strict=True)):
            if name is not None:
                sd = names[sds[i]] if i in sds else None
                height = call.functor if (call.functor, argument.name) in _HEIGHTS else ""
                yield name, Meaning(argument.kind, sd, i in deviating, height)
    elif (call.functor, len(names)) == _MEASURE:
        measured = _find_measure_kind(call.arguments[0])
        value, sd = names[1], names[2]
        if measured is not None:
            if value is not None:
                named = call.arguments[0][0].functor or ""
                height = named if (named, "H") in _HEIGHTS else ""
                yield value, Meaning(measured, sd, height=height)
            if sd is not None:
                yield sd, Meaning(measured, is_sd=True)


def _find_variable(argument: Sequence[Token]) -> str | None:
    if len(argument) == 1 and argument[0].kind is TokenKind.VARIABLE and argument[0].text != "_":
        return argument[0].text
    return None


def _pair_deviations(arguments: Sequence[Argument]) -> dict[int, int]:
    """Return which argument is the standard deviation of which.

    `Sd` is that of the argument before it, `SdU` that of `U`.
    """
    places = {argument.name: i for i, argument in enumerate(arguments)}
    found = {}
    for i, argument in enumerate(arguments):
        if argument.name == "Sd":
            found[i - 1] = i
        elif argument.name.startswith("Sd") and argument.name[2:] in places:
            found[places[argument.name[2:]]] = i
    return found


def _find_measure_kind(measure: Sequence[Token]) -> ArgumentKind | None:
    """Return the kind of a measure that is named as its fact: that of the argument with a
    deviation.
    """
    functor = measure[0].functor if measure else None
    for kind in FACT_SCHEMA:
        if kind.functor == functor:
            deviating = _pair_deviations(kind.arguments)
            return next((kind.arguments[i].kind for i in deviating), None)
    return None


def make_height_notes(found: Mapping[str, Meaning]) -> tuple[str, ...]:
    """Explain each of several different heights in one table; a single one needs no note.

    >>> make_height_notes(meanings("elevation(f1, A, _), top_of(t1, B, _)"))[0]
    'A is elevation: height of the middle of the face above the lowest point of its object'
    >>> make_height_notes(meanings("elevation(f1, A, _), elevation(f2, B, _)"))
    ()
    """
    named = {name: meaning.height for name, meaning in found.items() if meaning.height}
    if len(set(named.values())) < 2:
        return ()
    return tuple(
        f"{name} is {height}: {FACT_KINDS[height].meaning}" for name, height in named.items()
    )


def find_counting_unit(goal: str, length: str) -> str:
    """Return the unit in which a goal with numbers and lengths or areas counts; empty for another.

    >>> height = "elevation(F, H, _)"
    >>> find_counting_unit(f"{height}, H > 20", "m"), find_counting_unit(height, "m")
    ('m', '')
    """
    kinds = {meaning.kind for meaning in meanings(goal).values()}
    numbers = any(token.kind is TokenKind.NUMBER for token in tokens(goal))
    return length if numbers and kinds & {ArgumentKind.LENGTH, ArgumentKind.AREA} else ""


def length_unit(units: Sequence[str | None]) -> str:
    """Return the unit of lengths for scenes with these: metres, units, or both.

    >>> length_unit(["m", "m"]), length_unit([None]), length_unit(["m", None])
    ('m', 'units', 'm or units')
    """
    return " or ".join(dict.fromkeys(unit or "units" for unit in units)) or "units"


def unit(kind: ArgumentKind, length: str) -> str:
    """Return the unit of a kind as a reader writes it; empty where there is none.

    >>> unit(ArgumentKind.AREA, "m"), unit(ArgumentKind.DEGREES, "m"), unit(ArgumentKind.FACE, "m")
    ('m²', '°', '')
    """
    match kind:
        case ArgumentKind.DEGREES:
            return "°"
        case ArgumentKind.LENGTH:
            return length
        case ArgumentKind.AREA:
            return " or ".join(f"{one}²" for one in length.split(" or "))
        case ArgumentKind.PIXELS:
            return "px"
    return ""
