"""Environment in which SWI-Prolog starts, whatever the user's environment is."""

import locale
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

__all__ = ["PLACES", "starting_conditions"]

PLACES = ("LIBSWIPL_PATH", "SWI_HOME_DIR")
"""Variables of the environment that say where SWI-Prolog is."""

BOOT_FILE = "boot.prc"
"""File in SWI-Prolog's home; without it SWI-Prolog ends the whole process at start."""

LOCALE_VARIABLES = ("LC_ALL", "LC_CTYPE", "LANG")
"""Variables that set the text encoding, in order of precedence."""

UTF8_LOCALE = "C.UTF-8"

_LOG = logging.getLogger(__name__)


@contextmanager
def starting_conditions() -> Iterator[None]:
    """Give SWI-Prolog a current folder, a home that is one, and UTF-8 for its files' names."""
    with ExitStack() as stack:
        stack.enter_context(_existing_folder())
        stack.enter_context(_plain_arguments())
        home = os.environ.get("SWI_HOME_DIR")
        if home is not None and not (Path(home) / BOOT_FILE).is_file():
            _LOG.warning(
                "SWI_HOME_DIR=%s is no home of SWI-Prolog (no %s): ignored", home, BOOT_FILE
            )
            stack.enter_context(_environment({"SWI_HOME_DIR": None}))
        stack.enter_context(_utf8())
        yield


@contextmanager
def _existing_folder() -> Iterator[None]:
    """Stay in / if the current folder was deleted: SWI-Prolog crashes there."""
    try:
        Path.cwd()
    except OSError:
        pass
    else:
        yield
        return
    descriptor = -1
    with suppress(OSError):
        descriptor = os.open(".", os.O_RDONLY)
    os.chdir(os.sep)
    try:
        yield
    finally:
        if descriptor >= 0:
            # To where paths that others hold may lead again.
            with suppress(OSError):
                os.fchdir(descriptor)
            os.close(descriptor)


@contextmanager
def _plain_arguments() -> Iterator[None]:
    """Hide the command line, which pyswip encodes as UTF-8 and nobody reads: names may be none."""
    before = sys.argv
    sys.argv = ["facetlog"]
    try:
        yield
    finally:
        sys.argv = before


@contextmanager
def _utf8() -> Iterator[None]:
    """Have SWI-Prolog take text for UTF-8, as all our files are, whatever the locale."""
    stated = next((os.environ[name] for name in LOCALE_VARIABLES if os.environ.get(name)), "C")
    if "utf" in stated.lower() or not _is_known(UTF8_LOCALE):
        yield
        return
    changes: dict[str, str | None] = {"LC_CTYPE": UTF8_LOCALE}
    if os.environ.get("LC_ALL"):
        changes |= {"LC_ALL": None, "LANG": os.environ["LC_ALL"]}
    with _environment(changes):
        yield


def _is_known(name: str) -> bool:
    before = locale.setlocale(locale.LC_CTYPE)
    try:
        locale.setlocale(locale.LC_CTYPE, name)
    except locale.Error:
        return False
    locale.setlocale(locale.LC_CTYPE, before)
    return True


@contextmanager
def _environment(changes: dict[str, str | None]) -> Iterator[None]:
    """Change variables of the environment, None to unset one, and put them back."""
    before = {name: os.environ.get(name) for name in changes}
    _set(changes)
    try:
        yield
    finally:
        _set(before)


def _set(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
