"""Linear algebra on one thread: the matrices here are small, and where other work keeps the machine
busy the threads of a BLAS wait for one another, seconds where a single one takes milliseconds."""

__all__ = ["ONE_THREAD"]

# What the BLAS libraries that numpy comes with ask for the number of their threads, once when they
# are loaded.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
