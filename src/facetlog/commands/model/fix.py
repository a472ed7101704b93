"""Model files with all that is sure put right."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.commands.model.check import analysed, checked
from facetlog.commands.model.fault_text import counted
from facetlog.commands.model.files import is_stdin
from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_whole
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.grammar.faults import Fault

__all__ = ["fix_files"]


def fix_files(paths: Sequence[Path]) -> None:
    """Writes each file anew in which something is sure to be wrong, and says what was done.

    Raises InputError for standard input, and for a file that cannot be written.
    """
    from facetlog.grammar.fix_all import fixed

    if any(map(is_stdin, paths)):
        raise InputError("--fix needs files: what is read from standard input cannot be put right")
    for path in paths:
        before = analysed(path)
        if any(fault.code == "unreadable" for fault in before.faults):
            continue  # the check tells it
        found = fixed(before.file.source.text, partial(_faults, path))
        if found.text == before.file.source.text:
            continue
        write_whole(path, found.text.encode())
        for one in found.done:
            note(f"{path}:{one.line}:{one.column}: {one.title} [{one.code}]")
        note(f"{path}: {counted(len(found.done), 'fault')} put right")


def _faults(path: Path, text: str) -> "tuple[Fault, ...]":
    return checked(path, text)[1]
