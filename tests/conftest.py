"""Settings of all tests."""

import os
import signal

from hypothesis import settings

from facetlog.one_thread import ONE_THREAD

# As the command line does, before numpy is loaded: with two processes on two cores, threads of a
# BLAS that wait for one another make tests of small matrices up to sixty times slower.
for name in ONE_THREAD:
    os.environ.setdefault(name, "1")

# A shell without job control starts what is behind `&` with Ctrl-C ignored, and all programs
# inherit that: tests that press Ctrl-C need it as a terminal has it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# No test depends on a clock: machines differ, and others work beside. The runs that decide about
# landing (CI is set) try the same examples each time; all others try new ones.
settings.register_profile("untimed", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("untimed")
