"""Writes the reference of the model language into docs/models.md, between its two markers.

With `--check` nothing is written: the exit code is 1 if the page is not up to date.
"""

import math
import sys
from pathlib import Path

from facetlog.grammar.reference import BuiltThing, reference
from facetlog.grammar.units import Dimension
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS

PAGE = Path(__file__).resolve().parent.parent / "docs" / "models.md"
BEGIN = "<!-- The reference: made by scripts/write_reference.py, not to be edited by hand. -->\n"
END = "<!-- End of the reference. -->\n"


def built_things() -> tuple[BuiltThing, ...]:
    """What examples can build, as the reference tells it: angles in degrees."""
    kinds = {
        "length": (Dimension.LENGTH, float),
        "angle": (Dimension.ANGLE, math.degrees),
        "count": (Dimension.NUMBER, float),
    }
    return tuple(
        BuiltThing(
            builder.name,
            builder.meaning,
            tuple(
                (size.name, kinds[size.kind][0], kinds[size.kind][1](size.default))
                for size in builder.parameters
            ),
        )
        for builder in BUILDERS.values()
    )


def written(page: str) -> str:
    """The page with the reference as it should be; ValueError if it lacks the markers."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{PAGE.name} lacks {BEGIN.strip()} or {END.strip()}")
    return f"{before}{begin}\n{reference(built_things())}\n{end}{after}"


def main(arguments: list[str]) -> int:
    """Writes the reference, or says that it is not up to date; see the top of the file."""
    page = PAGE.read_text(encoding="utf-8")
    wanted = written(page)
    if wanted == page:
        return 0
    print(PAGE.name)
    if "--check" in arguments:
        return 1
    PAGE.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
