"""Writes rules/NAME.pl from rules/NAME.model, for each model that comes with facetlog.

With `--check` nothing is written: the exit code is 1, and the files are named, if one is not what
its model says.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

from facetlog.grammar.analysis import analyse
from facetlog.grammar.compile import compiled
from facetlog.grammar.library import BUILTIN

HEADER = (
    "% Made from {name}.model by `facetlog model compile`; not to be edited by hand.\n"
    "% After a change of the model run `make models`.\n"
)


def programs() -> Mapping[Path, str]:
    """The text of each built-in rule file that a model makes, by its path.

    Raises RuleSyntaxError, with all faults, if a model has errors.
    """
    return {
        path.with_suffix(".pl"): HEADER.format(name=path.stem) + compiled(analyse(path)).prolog
        for path in sorted(BUILTIN.glob("*.model"))
    }


def stale(wanted: Mapping[Path, str]) -> tuple[Path, ...]:
    """The files that do not hold the text that they should."""
    return tuple(
        path
        for path, text in wanted.items()
        if not path.exists() or path.read_text(encoding="utf-8") != text
    )


def main(arguments: list[str]) -> int:
    """Writes what is not up to date, or names it; see the top of the file."""
    wanted = programs()
    old = stale(wanted)
    for path in old:
        print(path.name)
        if "--check" not in arguments:
            path.write_text(wanted[path], encoding="utf-8")
    return 1 if old and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
