"""Plans of answers in arrays, as array_plan.pl writes them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.errors import EngineError
from facetlog.kb.arrays.scene_columns import FactKind
from facetlog.kb.engine.terms import Atom, Struct, Term

__all__ = [
    "Absent",
    "Argument",
    "Compare",
    "Constant",
    "Expression",
    "Fact",
    "Measured",
    "Operation",
    "Order",
    "Pairs",
    "Plan",
    "PlannedScene",
    "Step",
    "Summed",
    "Variable",
    "decode_plan",
    "variables_of",
]


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable by its number in the question."""

    number: int


@dataclass(frozen=True, slots=True)
class Constant:
    """An atom or a number."""

    value: Atom | int | float


Argument: TypeAlias = Variable | Constant


@dataclass(frozen=True, slots=True)
class Operation:
    """What arithmetic makes of its operands."""

    functor: str
    operands: tuple["Expression", ...]


Expression: TypeAlias = Variable | Constant | Operation


@dataclass(frozen=True, slots=True)
class Fact:
    """Each row of a fact that agrees with what is known."""

    kind: FactKind
    args: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class Compare:
    """Two numbers, by `<`, `=<`, `>`, `>=`, `=:=` or `=\\=`."""

    functor: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Order:
    """Two names in the standard order, by `@<`, `@=<`, `@>`, `@>=`, `==` or `\\==`."""

    functor: str
    left: Argument
    right: Argument


@dataclass(frozen=True, slots=True)
class Absent:
    """There is nothing that these steps find."""

    steps: tuple["Step", ...]


@dataclass(frozen=True, slots=True)
class Summed:
    """The variable `result` is the number of what the steps find, or sum, max or min of `of`."""

    functor: str
    of: Variable | None
    result: int
    steps: tuple["Step", ...]


@dataclass(frozen=True, slots=True)
class Measured:
    """The fact that has a value of each two faces, with the places of what it says of them.

    The value is to be inside of `bounds`: `near`, `between`, `at_least` or `at_most` these limits.
    """

    kind: FactKind
    first: int
    second: int
    value: int
    deviation: int
    bounds: str
    limits: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Pairs:
    """Faces of which each two pass the test of `text`, for Prolog; `way` if a fact says."""

    faces: tuple[Argument, ...]
    text: str
    way: Measured | None


Step: TypeAlias = Fact | Compare | Order | Absent | Summed | Pairs


@dataclass(frozen=True, slots=True)
class PlannedScene:
    """A scene that is asked; `generations` differ when facts of a kind have changed."""

    name: str
    module: str
    generations: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    """`columns` are the numbers of the variables called `names`, but for Scene in front of them."""

    names: tuple[str, ...]
    scenes: tuple[PlannedScene, ...]
    columns: tuple[int, ...]
    steps: tuple[Step, ...]
    kinds: tuple[FactKind, ...]


def decode_plan(term: Term) -> Plan:
    """The plan of a reply; EngineError if it is none."""
    match term:
        case Struct(
            "plan",
            (
                tuple(names),
                tuple(scenes),
                Struct("plan", (tuple(columns), tuple(steps), tuple(kinds))),
            ),
        ):
            return Plan(
                tuple(map(str, names)),
                tuple(map(_scene, scenes)),
                tuple(map(_integer, columns)),
                tuple(map(_step, steps)),
                tuple(map(_kind, kinds)),
            )
    raise _unreadable(term)


def variables_of(parts: Iterable[Step | Expression]) -> Iterator[int]:
    """The variables that occur in steps or expressions, those within Absent and Summed too."""
    for part in parts:
        match part:
            case Variable(number):
                yield number
            case Fact(_, args) | Operation(_, args) | Pairs(args):
                yield from variables_of(args)
            case Compare(_, left, right) | Order(_, left, right):
                yield from variables_of((left, right))
            case Absent(steps):
                yield from variables_of(steps)
            case Summed(_, _, result, steps):
                yield result
                yield from variables_of(steps)


def _scene(term: Term) -> PlannedScene:
    match term:
        case Struct("scene", (Atom(name), Atom(module), tuple(generations))):
            return PlannedScene(name, module, tuple(map(_integer, generations)))
    raise _unreadable(term)


def _kind(term: Term) -> FactKind:
    match term:
        case Struct("/", (Atom(name), int(arity))):
            return name, arity
    raise _unreadable(term)


def _integer(term: Term) -> int:
    if isinstance(term, int):
        return term
    raise _unreadable(term)


def _steps(term: Term) -> tuple[Step, ...]:
    if isinstance(term, tuple):
        return tuple(map(_step, term))
    raise _unreadable(term)


def _step(term: Term) -> Step:
    match term:
        case Struct("fact", (Atom(name), tuple(args))):
            return Fact((name, len(args)), tuple(map(_argument, args)))
        case Struct("compare", (Atom(functor), left, right)):
            return Compare(functor, _expression(left), _expression(right))
        case Struct("order", (Atom(functor), left, right)):
            return Order(functor, _argument(left), _argument(right))
        case Struct("absent", (steps,)):
            return Absent(_steps(steps))
        case Struct("summed", (Atom(functor), int(result), steps)):
            return Summed(functor, None, result, _steps(steps))
        case Struct("summed", (Struct(functor, (int(of),)), int(result), steps)):
            return Summed(functor, Variable(of), result, _steps(steps))
        case Struct("pairs", (tuple(faces), str(text), Atom("graph"))):
            return Pairs(tuple(map(_argument, faces)), text, None)
        case Struct("pairs", (tuple(faces), str(text), way)):
            return Pairs(tuple(map(_argument, faces)), text, _measured(way))
    raise _unreadable(term)


def _measured(term: Term) -> Measured:
    match term:
        case Struct("measured", (Atom(name), int(arity), *places, Struct(bounds, limits))):
            first, second, value, deviation = map(_integer, places)
            numbers = tuple(float(x) for x in limits if isinstance(x, int | float))
            return Measured((name, arity), first, second, value, deviation, bounds, numbers)
    raise _unreadable(term)


def _argument(term: Term) -> Argument:
    match term:
        case Struct("variable", (int(number),)):
            return Variable(number)
        case Struct("constant", (Atom() | int() | float() as value,)):
            return Constant(value)
    raise _unreadable(term)


def _expression(term: Term) -> Expression:
    match term:
        case Struct("variable" | "constant", _):
            return _argument(term)
        case Struct(functor, operands):
            return Operation(functor, tuple(map(_expression, operands)))
    raise _unreadable(term)


def _unreadable(term: Term) -> EngineError:
    return EngineError(f"Prolog's plan of an answer cannot be read: {term!r}")
