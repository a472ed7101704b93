"""Numbers as a reader wants them: as many digits as mean something, with their unit."""

import math

__all__ = ["amount", "measured", "sd_count", "with_unit"]

# More standard deviations than this say no more than this: the distribution's tails are not known.
MOST_SDS = 1000.0


def amount(value: float) -> str:
    """The number with four digits, and no exponent in everyday sizes.

    >>> amount(90.0), amount(0.25401), amount(12345.6)
    ('90', '0.254', '12346')
    """
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def measured(value: float, sd: float) -> str:
    """The number with no more digits than its deviation allows, which is given with two.

    >>> measured(71.23456, 1.1), measured(71.23456, 0.018), measured(0.5, 0.0)
    ('71.2', '71.23', '0.5')
    """
    if sd <= 0 or not math.isfinite(sd):
        return amount(value)
    digits = max(0, 1 - math.floor(math.log10(sd)))
    text = amount(round(value, digits))
    return "0" if text == "-0" else text


def sd_count(sds: float) -> str:
    """A number of standard deviations.

    >>> sd_count(3.42), sd_count(57.8), sd_count(1e9)
    ('3.4', '58', 'over 1000')
    """
    if sds > MOST_SDS:
        return f"over {MOST_SDS:.0f}"
    return f"{sds:.1f}" if sds < 10 else f"{sds:.0f}"


def with_unit(number: str, unit: str) -> str:
    """The number with its unit, a degree sign close to it.

    >>> with_unit("71.2", "°"), with_unit("0.3", "m"), with_unit("3", "")
    ('71.2°', '0.3 m', '3')
    """
    return f"{number}{unit}" if unit in ("°", "") else f"{number} {unit}"
