"""Numbers as a reader wants them: as many digits as mean something, in a unit that suits them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = [
    "PERCENT",
    "Unit",
    "amount",
    "beside",
    "choose_unit_for",
    "deviation",
    "format_lengths",
    "format_sd_count",
    "format_with_unit",
    "measured",
    "tell_apart",
]

# More standard deviations than this say no more than this: the distribution's tails are not known.
MOST_SDS = 1000.0
# What is smaller than this, as it is written, is written in a smaller unit: 0.07 mm, not 0.007 cm.
LEAST_WRITTEN = 0.01
# What is this much smaller than the largest number beside it says nothing, and asks for no unit.
NEGLIGIBLE = 1e-5
# A deviation below this is not written where it is also that small beside its value.
LEAST_SD = 5e-5
LEAST_RELATIVE_SD = 1e-4
NOTHING = 1e-12  # in whichever unit suits the value: rounding alone
# Digits behind the point that are written of numbers whose size is ordinary.
DIGITS = 6


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as it is written behind numbers, empty for pure ones; `size` is one of it in SI.

    `from_size` is the size in it from which it is preferred to the next smaller unit.
    """

    name: str
    size: float = 1.0
    from_size: float = 1.0

    def of(self, value: float) -> float:
        """Return the value in this unit, without what is far below anything that is measured."""
        return value if self.name == _UNSCALED.name else round(value / self.size, DIGITS)

    @property
    def is_degree(self) -> bool:
        """Whether it stands close to its number, and is understood without it."""
        return self.name == "°"


PERCENT = Unit("%", 1e-2)
"""The unit of shares."""
_UNSCALED = Unit("")
_UNITS = {
    "m": (Unit("m"), Unit("cm", 1e-2), Unit("mm", 1e-3)),
    "m²": (Unit("m²", from_size=0.1), Unit("cm²", 1e-4)),
}


def choose_unit_for(si_unit: str, *values: float) -> Unit:
    """Return the unit in which numbers that stand together are written, all in this unit of SI.

    The largest is at least 1 in it, and the smallest that means something has no row of zeros
    behind the point. Units of other things than lengths and areas stay as they are.

    >>> choose_unit_for("m", 0.254, 7e-05).name, choose_unit_for("m²", 0.0516).name
    ('mm', 'cm²')
    """
    units = _UNITS.get(si_unit)
    if units is None:
        return Unit(si_unit)
    sizes = [abs(value) for value in values if value and math.isfinite(value)]
    largest = max(sizes, default=0.0)
    least = min((size for size in sizes if size >= NEGLIGIBLE * largest), default=0.0)
    fitting = (
        unit
        for unit in units
        if largest >= unit.from_size * unit.size and least >= LEAST_WRITTEN * unit.size
    )
    return next(fitting, units[-1])


def amount(value: float) -> str:
    """Return the number with four digits, and no exponent in everyday sizes.

    >>> amount(90.0), amount(0.25401), amount(12345.6), amount(0.00002)
    ('90', '0.254', '12346', '0.00002')
    """
    if abs(value) >= 1000:
        return f"{value:.0f}"
    text = f"{value:.4g}"
    return _format_small_number(value) if "e-0" in text and abs(value) >= 10**-DIGITS else text


def beside(value: float, *others: float) -> str:
    """Return the number with no more digits behind the point than the largest of all has, of four.

    >>> beside(0.009072, 76.16), beside(0.254, 0.1), beside(12.0, 3.0)
    ('0.01', '0.254', '12')
    """
    largest = max((abs(size) for size in (value, *others) if math.isfinite(size)), default=0.0)
    if not math.isfinite(value) or largest == 0:
        return amount(value)
    return amount(round(value, 3 - math.floor(math.log10(largest))) + 0.0)


def measured(value: float, sd: float) -> str:
    """Return the number with no more digits than its deviation is written with, and no more than
    four.

    >>> measured(71.23456, 1.1), measured(254.0, 0.07), measured(0.5, 0.0)
    ('71.2', '254.0', '0.5')
    """
    spread = deviation(value, sd)
    if not spread or not (math.isfinite(sd) and math.isfinite(value)):
        return amount(value)
    digits = len(spread.partition(".")[2])
    rounded = round(value, digits)
    if rounded == 0:
        return "0"
    whole = math.floor(math.log10(abs(rounded))) + 1
    return f"{rounded:.{max(0, min(digits, 4 - whole))}f}"


def tell_apart(text: str, value: float, limit: float) -> tuple[str, str]:
    """Return the text of a value and that of a limit, with so many digits that they show which of
    both is greater, if they differ by more than rounding.

    >>> tell_apart("35", 35.2, 35.0), tell_apart("35", 34.9996, 35.0)
    (('35.2', '35'), ('34.9996', '35'))
    """
    written = amount(limit)
    for digits in range(1, DIGITS + 1):
        shown, there = float(text), float(written)
        if abs(value - limit) < 10**-DIGITS or (shown - there) * (value - limit) > 0:
            break
        text = f"{value:.{digits}f}"
        written = f"{limit:.{digits}f}".rstrip("0").rstrip(".")
    return text, written


def deviation(value: float, sd: float) -> str:
    """Return the standard deviation of a value with two digits; empty where it says nothing.

    >>> deviation(254.0, 0.0701), deviation(0.9994, 0.00024), deviation(1.0, 1e-9)
    ('0.07', '0.00024', '')
    >>> deviation(0.0, 1.4e-17)
    ''
    """
    if sd <= NOTHING or (sd < LEAST_SD and sd < LEAST_RELATIVE_SD * abs(value)):
        return ""
    text = f"{sd:.2g}" if sd < 10 else f"{sd:.0f}"
    return _format_small_number(float(text)) if "e-0" in text else text


def _format_small_number(value: float) -> str:
    """Return a small number without an exponent, with two digits at least."""
    text = f"{value:.{1 - math.floor(math.log10(abs(value)))}f}"
    return text.rstrip("0")


def format_lengths(values: Sequence[float], sd: float, si_unit: str, *, sign: str = ", ") -> str:
    """Return lengths that stand together, with one deviation, in the unit that suits them.

    >>> format_lengths((0.254,), 6.8e-05, "m"), format_lengths((0.2541, 0.1524), 0, "m", sign=" × ")
    ('254.0 ± 0.068 mm', '25.41 × 15.24 cm')
    >>> format_lengths((0.7362, 1.486), 5e-05, "m")
    '(736.20, 1486.00) ± 0.05 mm'
    """
    unit = choose_unit_for(si_unit, *values, sd)
    scaled, spread = [unit.of(value) for value in values], sd / unit.size
    largest = max(map(abs, scaled), default=0.0)
    said = deviation(largest, spread)
    if not said:
        return format_with_unit(sign.join(beside(value, largest) for value in scaled), unit.name)
    if len(scaled) == 1:
        return f"{measured(scaled[0], spread)} ± {format_with_unit(said, unit.name)}"
    # A place may be far from the origin, and be known to a fraction of that.
    digits = len(said.partition(".")[2])
    numbers = sign.join(f"{value:.{digits}f}" for value in scaled)
    return f"({numbers}) ± {format_with_unit(said, unit.name)}"


def format_sd_count(sds: float) -> str:
    """Return a number of standard deviations.

    >>> format_sd_count(3.42), format_sd_count(57.8), format_sd_count(1e9)
    ('3.4', '58', 'over 1000')
    """
    if sds > MOST_SDS:
        return f"over {MOST_SDS:.0f}"
    return f"{sds:.1f}" if sds < 10 else f"{sds:.0f}"


def format_with_unit(number: str, unit: str) -> str:
    """Return the number with its unit, a degree sign close to it.

    >>> format_with_unit("71.2", "°"), format_with_unit("0.3", "m"), format_with_unit("3", "")
    ('71.2°', '0.3 m', '3')
    """
    return f"{number}{unit}" if unit in ("°", "") else f"{number} {unit}"
