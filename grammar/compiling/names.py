"""The variables that the names of a model become."""

from facetlog.grammar.terms import Var

__all__ = ["Names"]


class Names:
    """Variables for names, each different; asked for again a name keeps its variable."""

    def __init__(self) -> None:
        self._of: dict[str, Var] = {}
        self._taken: set[str] = {"Thing", "Parts", "_"}

    def __getitem__(self, name: str) -> Var:
        """The variable of a name: `top` becomes Top."""
        if name not in self._of:
            self._of[name] = self.fresh(name)
        return self._of[name]

    def fresh(self, name: str) -> Var:
        """A new variable that is called like a name."""
        first = name[:1].upper()
        # A Prolog variable begins with a capital letter; not every script has one.
        stem = first + name[1:] if first.isascii() and first.isalpha() else f"V_{name}"
        found = stem
        number = 2
        while found in self._taken:
            found = f"{stem}{number}"
            number += 1
        self._taken.add(found)
        return Var(found)

    def copy(self) -> "Names":
        """The same names, to which more can be added."""
        other = Names()
        other._of = dict(self._of)
        other._taken = set(self._taken)
        return other
