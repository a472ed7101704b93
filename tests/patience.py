"""How long a limit may take to be kept, on a machine that may have other work."""

import os


def allowed(limit: float, grace: float = 1.0) -> float:
    """Seconds: the limit and its grace, longer where more processes than cores want to run."""
    crowd = os.getloadavg()[0] / (os.cpu_count() or 1)
    return (limit + grace) * max(1.0, 1.5 * crowd)
