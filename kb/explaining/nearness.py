"""How small a change is beside others: one order for values of all kinds and units."""

__all__ = ["NOISE_SDS", "Nearness", "nearness"]

NOISE_SDS = 3.0
"""Standard deviations within which a difference may be an error of measurement."""

# Angles have no size to be compared with: 0 is no less than 90.
RIGHT_ANGLE = 90.0

# To so many digits changes are compared: of those that differ by rounding alone the first is least,
# on every processor.
DIGITS = 9

Nearness = tuple[bool, float]
"""Sorts changes from the least; what an error of measurement explains comes before all else."""


def nearness(change: float, value: float, sd: float, kind: str) -> Nearness:
    """How small a change of a value of this kind (deg, length, ...) and standard deviation is.

    A change of at most three standard deviations may be an error of measurement: such are compared
    by their number of deviations, for they are the likelier the fewer these are. Beyond that no
    error explains it, the thing itself would have to be another: how well it was measured says
    nothing then, and a change is compared as a share of the value, before or after it, whichever is
    larger, and that of an angle as a share of a right angle.

    >>> near, far = nearness(0.02, 0.5, 0.01, "length"), nearness(0.02, 0.5, 0.001, "length")
    >>> near, far, near < far
    ((False, 2.0), (True, 0.0384615385), True)
    """
    size = abs(change)
    if sd > 0 and size <= NOISE_SDS * sd:
        return False, _rounded(size / sd)
    if kind == "deg":
        return True, _rounded(size / RIGHT_ANGLE)
    scale = max(abs(value), abs(value + change))
    return True, _rounded(size / scale) if scale > 0 else 0.0


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
