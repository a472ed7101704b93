"""Linear algebra on one thread: the matrices here are small, and where other work keeps the machine
busy the threads of a BLAS wait for one another, seconds where a single one takes milliseconds."""

from contextlib import AbstractContextManager

__all__ = ["ONE_THREAD", "use_one_thread"]

# What the BLAS libraries that numpy comes with ask for the number of their threads, once when they
# are loaded.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


def use_one_thread() -> AbstractContextManager[object]:
    """Return a context in which a BLAS that is loaded uses one thread."""
    from threadpoolctl import threadpool_limits

    limits: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits
