"""Shared by all commands: exit codes, one line for an error, and the options that several have."""

import errno
import inspect
import logging
import os
import platform
import sys
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from functools import wraps
from pathlib import Path
from shlex import quote
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from facetlog import __version__
from facetlog.__main__ import INTERRUPTED
from facetlog.errors import FacetlogError, InputError
from facetlog.safe_read import check_current_folder
from facetlog.terminal import error, error_lines, note

if TYPE_CHECKING:
    from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = [
    "NO",
    "YES",
    "AsJson",
    "Crisp",
    "Full",
    "JudgingOptions",
    "ModelOptions",
    "Models",
    "Overwrite",
    "Raw",
    "Trust",
    "command",
]

YES, NO, BROKEN_PIPE = 0, 1, 141  # the last: 128 + the signal's number
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})

_LOG = logging.getLogger(__name__)

Models = Annotated[
    list[Path] | None,
    typer.Option("--models", metavar="PATH", help="Model file or folder of models; repeatable."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Full = Annotated[bool, typer.Option("--full", help="Show every step of the proofs.")]
Crisp = Annotated[
    bool, typer.Option("--crisp", help="Take every measured value as exact, as the paper does.")
]
Raw = Annotated[
    bool, typer.Option("--raw", help="Show degrees without calibration, instead of confidences.")
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="Trust all given files: run models in Prolog, read what they name elsewhere.",
    ),
]
"""The user trusts all files given: models may be in Prolog, which is run as a program
(`KnowledgeBase.load_rules`), all models are judged in this process, and poses files and models may
name cameras, pictures and examples outside of their folder (`path_guard.py`)."""

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]


@dataclass(frozen=True, slots=True)
class ModelOptions:
    """The user's models besides the built-in ones."""

    models: Models = None
    trust: Trust = False

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files and folders of models."""
        return tuple(self.models or ())

    def to_words(self) -> str:
        """Return these options as they are typed, each with a space behind it."""
        words = [quote(f"--models={path}") for path in self.paths]
        words += ["--trust"] if self.trust else []
        return "".join(f"{word} " for word in words)

    def open_base(self) -> "KnowledgeBase":
        """Open a knowledge base with these models; errors as `open_models` raises them."""
        from facetlog.pipeline import open_models

        return open_models(self.paths, trusted=self.trust)


@dataclass(frozen=True, slots=True)
class JudgingOptions(ModelOptions):
    """The models, and how sure verdicts are said to be."""

    crisp: Crisp = False
    raw: Raw = False

    def open_base(self) -> "KnowledgeBase":
        """Open a knowledge base with these models; errors as `open_models` raises them."""
        from facetlog.pipeline import open_models

        return open_models(self.paths, trusted=self.trust, crisp=self.crisp, raw=self.raw)


def command(body: Callable[..., int]) -> Callable[..., None]:
    """Make a command of a function that returns its exit code; an error becomes one line.

    A parameter whose type is a dataclass stands for the options that are its fields: the command
    line has one option for each field, and the function gets the dataclass.
    """
    signature = inspect.signature(body)
    groups = {p.name: p.annotation for p in signature.parameters.values() if is_group(p.annotation)}

    @wraps(body)
    def run(**given: Any) -> None:
        began = perf_counter()
        _LOG.debug("facetlog %s, Python %s", __version__, platform.python_version())
        try:
            check_current_folder()
            for name, group in groups.items():
                given[name] = group(
                    **{f: given.pop(f) for f in inspect.signature(group).parameters}
                )
            code = body(**given)
            if not sys.stdout.closed:  # as the language server leaves it
                sys.stdout.flush()
        except FacetlogError as exc:
            for line in error_lines(exc):
                error(line)
            code = exc.exit_code
        except typer.Exit as exc:  # of an error that was reported when it came
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
            _discard_output()
            code = BROKEN_PIPE
        except OSError as exc:
            if exc.errno not in NO_ROOM:
                raise
            _discard_output()
            error(f"the output cannot be written: {exc.strerror}: make room")
            code = InputError.exit_code
        name = body.__name__.removesuffix("_command").replace("_", "-")
        _LOG.info("%s took %.3f s, exit code %d", name, perf_counter() - began, code)
        raise typer.Exit(code)

    # Typer reads the options from the signature.
    flat: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        group = groups.get(parameter.name)
        flat += [parameter] if group is None else inspect.signature(group).parameters.values()
    keywords = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in flat]
    run.__signature__ = inspect.Signature(keywords)  # type: ignore[attr-defined]
    run.__annotations__ = {}
    return run


def is_group(kind: object) -> bool:
    """Tell whether a parameter's type stands for a group of options."""
    return isinstance(kind, type) and is_dataclass(kind)


def _discard_output() -> None:
    """Discard what is still buffered for standard output, so that it is not written at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
