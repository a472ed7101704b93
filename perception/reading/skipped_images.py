"""Unusable pictures of a poses file: one line for each kind of fault, however many pictures."""

from collections.abc import Iterable
from dataclasses import dataclass

from facetlog.perception.name_lists import named


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A picture's name, the message about its fault, and its `place` as named in that message."""

    name: str
    line: str
    place: str


def lines_of(left_out: Iterable[LeftOut]) -> tuple[str, ...]:
    """Return the message of the first picture of each kind of fault, with the names of the others.

    >>> lines_of(LeftOut(f"{k}.png", f"picture a/{k}.png is cut off", f"a/{k}.png") for k in "123")
    ('picture a/1.png is cut off; left out, and so are 2.png, 3.png',)
    """
    kinds: dict[str, list[LeftOut]] = {}
    for picture in left_out:
        kinds.setdefault(picture.line.replace(picture.place, ""), []).append(picture)
    lines = []
    for first, *rest in kinds.values():
        others = named([picture.name for picture in rest])
        same = f", and so {'are' if len(rest) > 1 else 'is'} {others}" if rest else ""
        lines.append(f"{first.line}; left out{same}")
    return tuple(lines)
