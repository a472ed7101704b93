"""Measures as a reader names them: which height it is that was measured, and of which part."""

import re
from collections.abc import Mapping

__all__ = [
    "describe_height",
    "describe_limit",
    "describe_ratio",
    "measure_words",
    "replace_faces_by_roles",
]

# Heights are above the lowest point of the thing, but for an own height.
_HEIGHTS = {
    "elevation": "the height of {}'s middle",
    "top_of": "the height of {}'s highest point",
    "bottom_of": "the height of {}'s lowest point",
    "height": "{}'s own height",
}
_SIDE_TILT = re.compile(r"\bside_tilt\(([^\W\d]\w*)\)")
_OF_TWO = {
    "shared_height": "shared height of {} and {}",
    "sunk_share": "sunk share of {} and {}",
    "over_share": "overlap of {} and {} from above",
}
_TWO = re.compile(rf"\b({'|'.join(_OF_TWO)})\((\w+), (\w+)\)")
_HEIGHT = re.compile(rf"\b({'|'.join(_HEIGHTS)})\(([^\W\d]\w*)\)")
# One measure over another or a number: neither is a sum, which stands in brackets.
_RATIO = re.compile(r"(\w+\([^()]*\))/(\w+\([^()]*\)|[\d.]+)")
_SHARE = re.compile(r"^(-?[\d.]+(?:e-?\d+)?)\*(.+)$")


def measure_words(measure: str) -> str:
    """Return the measure as it is written, but heights, of which there are several, by what they
    are of.

    >>> measure_words("elevation(f1)"), measure_words("length(f1)")
    ("height of f1's middle", 'length(f1)')
    >>> measure_words("elevation(f1)-bottom_of(f2)")
    "height of f1's middle - height of f2's lowest point"
    """
    words = _HEIGHT.sub(lambda m: _HEIGHTS[m[1]].format(m[2]).removeprefix("the "), measure)
    words = _TWO.sub(lambda m: _OF_TWO[m[1]].format(m[2], m[3]), words)
    words = _SIDE_TILT.sub(r"tilt of \1's most level side", words)
    return re.sub(r"(?<=[a-z)])([-+])(?=[a-z(])", r" \1 ", words) if words != measure else measure


def describe_ratio(measure: str) -> tuple[str, str]:
    """Return the measure and the whole that it is a share of, empty where the measure is no ratio
    of two.

    >>> describe_ratio("width(f1)/length(f1)"), describe_ratio("fill(f1)")
    (('width(f1)', ' of length(f1)'), ('fill(f1)', ''))
    """
    found = _RATIO.fullmatch(measure)
    if found is None:
        return measure_words(measure), ""
    return measure_words(found[1]), f" of {measure_words(found[2])}"


def describe_height(measure: str) -> str:
    """Return the thing that a height belongs to; empty for what is none.

    >>> describe_height("elevation(f1)"), describe_height("width(f1)")
    ("of f1's middle", '')
    """
    found = _HEIGHT.fullmatch(measure)
    words = "" if found is None else _HEIGHTS[found[1]].format(found[2])
    return words.removeprefix("the height ") if words.startswith("the height ") else ""


def describe_limit(limit: str) -> str:
    """Return a limit that was measured itself, as an author would write it.

    >>> describe_limit("0.75*top_of(t1)"), describe_limit("width(f2)")
    ("75 % of the height of t1's highest point", 'width(f2)')
    """
    share = _SHARE.match(limit)
    if share is None:
        return measure_words(limit)
    whole = _HEIGHT.sub(lambda m: _HEIGHTS[m[1]].format(m[2]), share[2])
    return f"{100 * float(share[1]):g} % of {whole}"


def replace_faces_by_roles(text: str, roles: Mapping[str, str]) -> str:
    """Return the text with the parts that faces play in place of the faces' names.

    >>> replace_faces_by_roles("height of f1's middle", {"f1": "seat"})
    "height of the seat's middle"
    >>> replace_faces_by_roles("fill(f1)", {"f1": "seat"})
    'fill(seat)'
    """

    def role(match: re.Match[str]) -> str:
        name, owns = roles[match[1]], match[2]
        return f"the {name}{owns}" if owns else name

    if not roles:
        return text
    return re.sub(rf"\b({'|'.join(map(re.escape, roles))})\b((?:'s)?)", role, text)
