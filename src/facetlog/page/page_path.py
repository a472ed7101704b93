"""Check of a page's path."""

from collections.abc import Iterable
from pathlib import Path

from facetlog.output_file import OWN_PAGE, check_output_file

SUFFIXES = (".html", ".htm")


def check_page(
    path: Path, option: str, inputs: Iterable[Path] = (), *, overwrite: bool | None = False
) -> None:
    """Raise InputError if no page may be written there, as `check_output_file` does.

    A page of facetlog is replaced, another file only with `overwrite`, and never if that is None.
    """
    check_output_file(path, option, inputs, suffixes=SUFFIXES, own=OWN_PAGE, overwrite=overwrite)
