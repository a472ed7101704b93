"""Where a page may be written."""

from pathlib import Path

from facetlog.errors import InputError

__all__ = ["check_page"]

SUFFIXES = (".html", ".htm")


def check_page(path: Path) -> None:
    """Raises InputError if no page can be written there: to be called before any work.

    A page that is there is replaced, no other file.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path} is no page: give a file whose name ends with .html")
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise InputError(f"{path} cannot be written: give a file in a folder that exists")
