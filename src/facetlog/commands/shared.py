"""What all commands share: exit codes, one line for an error, and the options that several have."""

import errno
import logging
import os
import platform
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from time import perf_counter
from typing import Annotated, ParamSpec

import typer

from facetlog import __version__
from facetlog.__main__ import INTERRUPTED
from facetlog.errors import FacetlogError, InputError
from facetlog.regular_file import check_current_folder
from facetlog.terminal import error, error_lines, note

__all__ = ["NO", "YES", "AsJson", "Full", "Models", "Raw", "Trust", "command"]

YES, NO, BROKEN_PIPE = 0, 1, 141  # the last: 128 + the signal's number
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})

P = ParamSpec("P")

_LOG = logging.getLogger(__name__)

Models = Annotated[
    list[Path] | None,
    typer.Option("--models", metavar="PATH", help="Your own models: a file or folder; repeatable."),
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object instead of text.")]
Full = Annotated[bool, typer.Option("--full", help="Every step of the proofs, not only reasons.")]
Raw = Annotated[
    bool,
    typer.Option("--raw", help="Degrees as measured values give them, not calibrated."),
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", help="What you give is yours: models in Prolog are run, pictures anywhere."
    ),
]
"""The user trusts all files given: models may be in Prolog, which is run as a program
(`KnowledgeBase.load_rules`), all models are judged in this process, and poses files may name
cameras and pictures outside of their folder (`own_folder.py`)."""


def command(body: Callable[P, int]) -> Callable[P, None]:
    """A command that ends with the exit code of its body, and with a line for an error."""

    @wraps(body)
    def ending(*args: P.args, **kwargs: P.kwargs) -> None:
        began = perf_counter()
        _LOG.debug("facetlog %s, Python %s", __version__, platform.python_version())
        try:
            check_current_folder()
            code = body(*args, **kwargs)
            if not sys.stdout.closed:  # as the language server leaves it
                sys.stdout.flush()
        except FacetlogError as exc:
            for line in error_lines(exc):
                error(line)
            code = exc.exit_code
        except typer.Exit as exc:  # of what was said when it came
            code = exc.exit_code
        except RecursionError:
            error("what was given is nested too deeply")
            code = InputError.exit_code
        except MemoryError:
            error("what was given needs more memory than there is: give less at once")
            code = InputError.exit_code
        except KeyboardInterrupt:
            note("interrupted")
            code = INTERRUPTED
        except BrokenPipeError:  # the reader went away, as `| head` does
            _write_no_more()
            code = BROKEN_PIPE
        except OSError as exc:
            if exc.errno not in NO_ROOM:
                raise
            _write_no_more()
            error(f"the output cannot be written: {exc.strerror}: make room")
            code = InputError.exit_code
        name = body.__name__.removesuffix("_command").replace("_", "-")
        _LOG.info("%s took %.3f s, exit code %d", name, perf_counter() - began, code)
        raise typer.Exit(code)

    del ending.__annotations__["return"]
    return ending


def _write_no_more() -> None:
    """What is still buffered for standard output is not written at the end either."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
