"""What all tests share."""

import signal

# A shell without job control starts what is behind `&` with Ctrl-C ignored, and all programs
# inherit that: tests that press Ctrl-C need it as a terminal has it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
