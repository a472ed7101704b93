"""Recognition of things made of flat faces, from posed pictures to a verdict that says why."""

import os  # pathlib takes 20 ms to load, in which a Ctrl-C would be a traceback

__version__ = "0.1.0"
__all__ = ["__version__"]

# A checkout without symbolic links (an archive, some file systems) has the five rooms only at
# the top of the repository: look for them there.
_here = os.path.dirname(os.path.realpath(__file__))  # noqa: PTH120
if not os.path.isdir(os.path.join(_here, "kb")):  # noqa: PTH112, PTH118
    __path__.append(os.path.dirname(os.path.dirname(_here)))  # noqa: PTH120
