"""Answers as a table: numbers aligned at their points, and rounded by their deviations.

All lengths of a table are in one unit, and all areas, so that columns can be compared.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rich.cells import cell_len, set_cell_size

from facetlog.kb.engine.terms import Atom, Term
from facetlog.kb.explaining.amounts import Unit, amount, choose_unit_for, format_with_unit
from facetlog.query_shell.meanings import Meaning, unit
from facetlog.query_shell.shown_terms import shown, visible

GAP = "  "

SCENE = "Scene"
"""The first column if several scenes are asked."""

NARROWEST = 6
"""Columns are not cut below this many cells to fit a terminal."""

MOST_DIGITS = 6
"""Digits after the point that a column may have; what is smaller is written with an exponent."""

DIGITS = 4
"""Digits of the greatest number of a column whose deviations are not known."""


@dataclass(frozen=True, slots=True)
class _Cell:
    """A cell's text and, for numbers, how many cells stand before the decimal point."""

    text: str
    before_point: int | None


class Table:
    """Lays out blocks of answers under one another; columns only ever grow wider."""

    def __init__(
        self,
        names: Sequence[str],
        meanings: Mapping[str, Meaning],
        length: str,
        *,
        width: int | None = None,
        scenes: Collection[str] = (),
    ) -> None:
        """Make a table; `length` is the unit of lengths as they come, `width` the terminal's or
        None.

        They are shown in a unit that suits those of the first block.

        Names of `scenes` stand without quotation marks, as in the column Scene.
        """
        self.names = tuple(names)
        self._meanings = tuple(meanings.get(name) for name in self.names)
        self._given = tuple(unit(m.kind, length) if m else "" for m in self._meanings)
        self._units: tuple[Unit, ...] = ()
        places = {name: i for i, name in enumerate(self.names)}
        self._sds = tuple(places.get(m.sd) if m and m.sd else None for m in self._meanings)
        self._limit = width
        self._scenes = frozenset(scenes)
        self.is_cut = False
        """Whether a cell was too wide for the terminal, and ends with …"""
        self._widths = [0] * len(self.names)

    def block(self, rows: Sequence[Sequence[Term]]) -> list[str]:
        """Format some rows as lines."""
        rows = self._convert_units(rows)
        columns = [self._format_column(i, rows) for i in range(len(self.names))]
        for i, column in enumerate(columns):
            cells = map(_count_cells, (self._heads[i], *column))
            self._widths[i] = max(self._widths[i], *cells)
        self._fit_width()
        right = self._find_numeric(rows)
        return [self._format_line(texts, right) for texts in zip(*columns, strict=True)]

    def head(self, rows: Sequence[Sequence[Term]]) -> list[str]:
        """Return the two lines above the table; call it after the first block, with its rows."""
        rule = ["─" * width for width in self._widths]
        return [self._format_line(self._heads, self._find_numeric(rows)), GAP.join(rule)]

    def cells(
        self, rows: Sequence[Sequence[Term]]
    ) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
        """Return the heads of the columns and the cells of some rows, none cut."""
        rows = self._convert_units(rows)
        columns = [self._format_column(i, rows) for i in range(len(self.names))]
        return self._heads, tuple(zip(*columns, strict=True))

    def values(self, row: Sequence[Term]) -> tuple[str, ...]:
        """Format the values of one row, each with its unit."""
        rows = self._convert_units([row])
        texts = (self._format_column(i, rows)[0] for i in range(len(self.names)))
        return tuple(map(format_with_unit, texts, (unit.name for unit in self._units)))

    def iter_unit_notes(self) -> Iterator[str]:
        """Say of each unit that was chosen for the table what a goal counts in."""
        pairs = {u.name: (u.size, given) for u, given in zip(self._units, self._given, strict=True)}
        for name, (size, given) in pairs.items():
            if given and name != given:
                yield f"goals count in {given}: 1 {name} is {size:g}"

    @property
    def _heads(self) -> tuple[str, ...]:
        return tuple(
            f"{name} ({unit.name})" if unit.name else name
            for name, unit in zip(self.names, self._units, strict=True)
        )

    def _convert_units(self, rows: Sequence[Sequence[Term]]) -> list[tuple[Term, ...]]:
        """Convert lengths and areas to the table's units, which the first rows determine."""
        if not self._units:
            of_sign = {
                sign: choose_unit_for(
                    sign,
                    *(
                        value
                        for row in rows
                        for value, given in zip(row, self._given, strict=True)
                        if given == sign and isinstance(value, float)
                    ),
                )
                for sign in dict.fromkeys(self._given)
            }
            self._units = tuple(of_sign[sign] for sign in self._given)
        sizes = [unit.size for unit in self._units]
        return [
            tuple(
                value / size if size != 1 and isinstance(value, float) else value
                for value, size in zip(row, sizes, strict=True)
            )
            for row in rows
        ]

    def _find_numeric(self, rows: Sequence[Sequence[Term]]) -> tuple[bool, ...]:
        return tuple(
            all(_is_number(row[i]) for row in rows) if rows else False
            for i in range(len(self.names))
        )

    def _format_line(self, texts: Sequence[str], right: Sequence[bool]) -> str:
        cells = []
        for text, width, at_right in zip(texts, self._widths, right, strict=True):
            if _count_cells(text) > width:
                text = set_cell_size(text, width - 1) + "…"
                self.is_cut = True
            space = " " * (width - _count_cells(text))
            cells.append(space + text if at_right else text + space)
        return GAP.join(cells).rstrip()

    def _fit_width(self) -> None:
        """Cut the widest columns until the table fits the terminal."""
        if self._limit is None:
            return
        spare = self._limit - len(GAP) * (len(self._widths) - 1)
        while sum(self._widths) > spare and max(self._widths) > NARROWEST:
            self._widths[self._widths.index(max(self._widths))] -= 1

    def _format_column(self, i: int, rows: Sequence[Sequence[Term]]) -> list[str]:
        meaning, sd = self._meanings[i], self._sds[i]
        is_sd = meaning is not None and meaning.is_sd
        if self.names[i] == SCENE:  # a name, not a term to be typed again
            return [visible(str(row[i])) for row in rows]
        digits = _count_digits([row[i] for row in rows])
        cells = [self._cell(row[i], _find_spread(row, i, sd, is_sd=is_sd), digits) for row in rows]
        points = [cell.before_point for cell in cells]
        if not cells or None in points:
            return [cell.text for cell in cells]
        # All numbers: after the point each is filled up to the longest.
        after = max(len(c.text) - (c.before_point or 0) for c in cells)
        return [c.text + " " * (after - len(c.text) + (c.before_point or 0)) for c in cells]

    def _cell(self, value: Term, spread: float, digits: int) -> _Cell:
        if isinstance(value, Atom) and value.name in self._scenes:
            return _Cell(visible(value.name), None)
        return _cell(value, spread, digits)


def _is_number(term: Term) -> bool:
    return isinstance(term, int | float | Fraction)


def _find_spread(row: Sequence[Term], i: int, sd: int | None, *, is_sd: bool) -> float:
    """Return the deviation by which a number is rounded, of a deviation itself; 0 if none."""
    spread = row[i] if is_sd else row[sd] if sd is not None else 0.0
    return spread if isinstance(spread, float) and math.isfinite(spread) else 0.0


def _count_digits(values: Sequence[Term]) -> int:
    """Return the digits after the point that show four of the greatest number."""
    sizes = [abs(v) for v in values if isinstance(v, float) and math.isfinite(v)]
    greatest = max(sizes, default=0.0)
    return DIGITS - 1 - math.floor(math.log10(greatest)) if greatest > 0 else 0


def _cell(value: Term, spread: float, digits: int) -> _Cell:
    match value:
        case float():
            text = _format_float(value, spread, digits)
        case int() | Fraction():
            text = shown(value)
        case _:
            return _Cell(visible(shown(value)), None)
    point = text.find(".")
    return _Cell(text, len(text) if point < 0 else point)


def _format_float(value: float, spread: float, digits: int) -> str:
    """Round a number to the second digit of its deviation; without one, as its column."""
    if spread > 0:
        digits = 1 - math.floor(math.log10(spread))
    if digits > MOST_DIGITS or not math.isfinite(value):
        return amount(value)
    text = f"{value:.{max(0, digits)}f}"
    if text.strip("-0."):
        return text
    # Not 0 without a reason: what a deviation makes nothing is, what the column does not.
    return text.removeprefix("-") if spread > 0 or value == 0 else f"{value:.1e}"


def _count_cells(text: str) -> int:
    """Count the cells of a terminal that a text takes; ASCII needs no look at each character."""
    return len(text) if text.isascii() else cell_len(text)
