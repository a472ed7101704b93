"""Sets: all that satisfy a condition, given the singular parts.

What may be a member is found once for a clause (members/5); how far each is one is a test of its
own, a word of the model: each member counts as far as that test holds of it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.measures import Bound
from facetlog.grammar.compiling.names import Names
from facetlog.grammar.scope import THIS, Scope, SetSymbol, conditions_in, names_in
from facetlog.grammar.terms import Atom, Struct, Term, Var
from facetlog.grammar.vocabulary import OPENING, PIECE, Kinds

if TYPE_CHECKING:
    from facetlog.grammar.compiling.writer import MeasureWriter

__all__ = ["SetShape", "set_shapes"]


@dataclass(frozen=True, slots=True)
class SetShape:
    """A set, the parts of its members that are asked for, and the word that says who is one.

    A member is the thing or element itself, or, where its own parts are asked for (`seat.back`),
    Member-Part-...; `needs` are the singular parts that its condition names.
    """

    symbol: SetSymbol
    roles: tuple[tuple[str, Kinds], ...]
    needs: tuple[str, ...]
    needs_thing: bool
    word: str
    where: s.Expression | None

    @property
    def separate(self) -> bool:
        """Whether members that belong together count once: no two pieces or openings do."""
        return self.symbol.owned.node.separate and self.symbol.kinds not in (PIECE, OPENING)

    def variables(self, names: Names, stem: str) -> tuple[Var, ...]:
        return tuple(names[n] for n in (stem, *(f"{stem}_{role}" for role, _ in self.roles)))

    def pattern(self, names: Names) -> Term:
        """The term of a member."""
        return _joined(self.variables(names, self.symbol.name))

    def bound(self, names: Names) -> dict[str, Bound]:
        """What the set's name, and its members' parts, stand for."""
        return self._bound(self.variables(names, self.symbol.name), self.symbol.name)

    def _bound(self, variables: tuple[Var, ...], name: str) -> dict[str, Bound]:
        first, *rest = variables
        found = {name: Bound(first, self.symbol.kinds, self.symbol.model)}
        for (role, kinds), variable in zip(self.roles, rest, strict=True):
            found[f"{name}.{role}"] = Bound(variable, kinds)
        return found

    def test(self, writer: "MeasureWriter") -> Term:
        """The test that the member is one."""
        return self._test(self.variables(writer.names, self.symbol.name), writer)

    def _test(self, variables: tuple[Var, ...], writer: "MeasureWriter") -> Term:
        tests: list[Term] = []
        if self.symbol.model:
            tests.append(Struct("is_a", (variables[0], Atom(self.symbol.model))))
        if self.where is not None:
            tests.append(self.said_of(variables, writer))
        return tests[0] if len(tests) == 1 else Struct("all", (tuple(tests),))

    def said_of(self, variables: tuple[Var, ...], writer: "MeasureWriter") -> Struct:
        """The word that says who is a member, of such variables."""
        needed = [writer.bound(name).term for name in self.needs]
        if self.needs_thing:
            needed.append(Var("Thing"))
        return Struct(self.word, (*variables, *needed))

    def implied(self, writer: "MeasureWriter", body: Term) -> Term:
        """What must be so of each member, as far as it is one."""
        test = self.test(writer)
        return body if test == Struct("all", ((),)) else Struct("implies", (test, body))

    def copy(self, writer: "MeasureWriter", name: str) -> tuple[Term, dict[str, Bound], Term]:
        """Pattern, names and test of a member that is called otherwise."""
        stems = (name, *(f"{name}_{role}" for role, _ in self.roles))
        variables = tuple(writer.names.fresh(stem) for stem in stems)
        return _joined(variables), self._bound(variables, name), self._test(variables, writer)


def _joined(variables: tuple[Var, ...]) -> Term:
    term: Term = variables[0]
    for variable in variables[1:]:
        term = Struct("-", (term, variable))
    return term


def set_shapes(scope: Scope) -> dict[str, SetShape]:
    """The sets of a model by name."""
    model = scope.model
    statements: list[s.Node] = [owned.node for _, owned in model.lines]
    statements += [owned.node for owned in model.parts]
    statements += [owned.node for owned in model.sizes]
    asked = _members_asked(statements)
    shapes = {}
    for symbol in scope.sets:
        own = scope.roles.get(symbol.model, {})
        roles = tuple(
            (role, own[role]) for role in sorted(asked.get(symbol.name, ())) if role in own
        )
        where = scope.where(symbol)
        named = names_in(where, scope)
        searches = _searches(where, scope) or "count" in named
        needs = tuple(p.name for p in scope.singular if searches or p.name in named)
        word = f"{model.name}.{symbol.name}"
        shapes[symbol.name] = SetShape(
            symbol,
            roles,
            needs,
            searches or THIS in named,
            word,
            where,
        )
    return shapes


def _searches(node: s.Expression | None, scope: Scope) -> bool:
    """Whether a condition goes through the thing: then it needs the thing and all parts."""
    return any(
        isinstance(inner, s.There | s.Each | s.EachOf | s.Aggregate)
        for one in conditions_in(node, scope)
        for inner in s.walk(one)
    )


def _members_asked(nodes: Iterable[s.Node]) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for node in nodes:
        for inner in s.walk(node):
            if isinstance(inner, s.Member):
                found.setdefault(inner.owner.text, set()).add(inner.part.text)
    return found
