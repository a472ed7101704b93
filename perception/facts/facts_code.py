"""A digest of the code that reads scene files, checks them, and makes facts of them."""

import hashlib
from functools import cache
from pathlib import Path

FACTS_CODE = ("*.py", "facts/**/*.py", "pieces/**/*.py", "space/**/*.py", "surfaces/**/*.py")
"""Modules of perception that a scene file goes through on its way to facts."""


SHAPES_CODE = (*FACTS_CODE, "shapes/**/*.py", "reading/*.py", "reading/shape_files/**/*.py")
"""Files that scenes of meshes and clouds depend on, too."""


@cache
def facts_code_hash(
    room: Path = Path(__file__).parents[1], patterns: tuple[str, ...] = FACTS_CODE
) -> str:
    """Return a digest of those modules' text: some 400 kB, 1.5 ms, once a process.

    A version is not enough: between two of them a check may be added that a scene does not pass
    whose facts were kept.
    """
    total = hashlib.sha256()
    for pattern in patterns:
        for path in sorted(room.glob(pattern)):
            total.update(f"{path.relative_to(room)}\n".encode())
            total.update(path.read_bytes())
    return total.hexdigest()
