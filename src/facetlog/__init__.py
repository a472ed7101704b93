"""Recognition of things made of flat faces, from posed pictures to a verdict that says why."""

from pathlib import Path

__version__ = "0.1.0"
__all__ = ["__version__"]

# A checkout without symbolic links (an archive, some file systems) has the five rooms only at
# the top of the repository: look for them there.
_here = Path(__file__).resolve().parent
if not (_here / "kb").is_dir():
    __path__.append(str(_here.parents[1]))
