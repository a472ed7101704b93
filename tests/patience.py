"""How long a test waits for something that must end at last, on a machine that may be busy."""

# Seconds: what is tested would go on for ever, or end for another cause, without its limit.
GRACE = 15.0


def allowed(limit: float, grace: float = GRACE) -> float:
    """Return the seconds after which a limit counts as not kept."""
    return limit + grace
