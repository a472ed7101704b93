"""Facts as a reader wants them: what they are about, then their values with unit and deviation."""

from collections.abc import Iterator, Sequence

from facetlog.kb.explaining.amounts import amount, deviation, length_words, measured, with_unit
from facetlog.perception.facts.fact_schema import FACT_KINDS, ArgumentKind, FactKind, Value

__all__ = ["fact_words"]

_UNITS = {ArgumentKind.DEGREES: "°", ArgumentKind.PIXELS: "px"}


def fact_words(functor: str, args: Sequence[Value], length_unit: str | None) -> str:
    """The fact in words; as a term where the schema does not have it.

    >>> fact_words("elevation", ("f1", 0.15232, 3.95e-05), "m")
    'elevation(f1) = 152.3 ± 0.04 mm'
    >>> fact_words("thing_size", ("t1", 0.2541, 0.2034, 0.15), "m")
    'thing_size(t1): L = 25.41 cm, W = 20.34 cm, H = 15 cm'
    >>> fact_words("convex", ("f1", "f2"), "m")
    'convex(f1, f2)'
    """
    kind = FACT_KINDS.get(functor)
    if kind is None or kind.arity != len(args):
        return f"{functor}({', '.join(map(str, args))})"
    about = f"{functor}({', '.join(map(str, args[: kind.keys]))})"
    values = list(_values(kind, args, length_unit))
    if len(values) == 1:
        return f"{about} = {values[0][1]}"
    said = ", ".join(f"{name} = {text}" for name, text in values)
    return f"{about}: {said}" if said else about


def _values(
    kind: FactKind, args: Sequence[Value], length_unit: str | None
) -> Iterator[tuple[str, str]]:
    """The values behind the keys by their names, each with its deviation."""
    names = [argument.name for argument in kind.arguments]
    for place in range(kind.keys, kind.arity):
        argument, value = kind.arguments[place], args[place]
        if argument.name.startswith("Sd") and place > kind.keys:
            continue
        own = f"Sd{argument.name}"
        following = place + 1 < kind.arity and names[place + 1] == "Sd"
        spread = args[names.index(own)] if own in names else args[place + 1] if following else 0.0
        yield argument.name, _value(argument.kind, value, spread, length_unit)


def _value(kind: ArgumentKind, value: Value, spread: Value, length_unit: str | None) -> str:
    if isinstance(value, str) or isinstance(spread, str):
        return str(value)
    if kind in (ArgumentKind.LENGTH, ArgumentKind.AREA):
        square = "²" if kind is ArgumentKind.AREA else ""
        return length_words((value,), spread, f"{length_unit}{square}" if length_unit else "")
    unit = _UNITS.get(kind, "")
    said = deviation(value, spread)
    number = measured(value, spread) if said else amount(value)
    return f"{with_unit(number, unit)}{f' ± {with_unit(said, unit)}' if said else ''}"
