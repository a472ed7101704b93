"""Recognition of things made of flat faces, from posed pictures to a verdict that says why."""

import os  # pathlib takes 20 ms to load, in which a Ctrl-C would be a traceback

# Types for who checks them; at run time what is exported is loaded when it is first named.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from facetlog.errors import FacetlogError, InputError
    from facetlog.kb.explaining.verdict import Verdict
    from facetlog.library.calls import ask, classify, classify_batch, read_scene, recognize
    from facetlog.library.gallery import Gallery
    from facetlog.library.result import Reason, Result
    from facetlog.perception.scene import Scene
    from facetlog.perception.types import View

__version__ = "0.1.0"
"""The version of facetlog."""

__all__ = [
    "FacetlogError",
    "Gallery",
    "InputError",
    "Reason",
    "Result",
    "Scene",
    "Verdict",
    "View",
    "__version__",
    "ask",
    "classify",
    "classify_batch",
    "read_scene",
    "recognize",
]

# The modules of classes; functions are in library.calls.
_PLACES = {
    "FacetlogError": "errors",
    "Gallery": "library.gallery",
    "InputError": "errors",
    "Reason": "library.result",
    "Result": "library.result",
    "Scene": "perception.scene",
    "Verdict": "kb.explaining.verdict",
    "View": "perception.types",
}

# A checkout without symbolic links (an archive, some file systems) has the five packages
# only at the top of the repository: look for them there.
_here = os.path.dirname(os.path.realpath(__file__))  # noqa: PTH120
if not os.path.isdir(os.path.join(_here, "kb")):  # noqa: PTH112, PTH118
    __path__.append(os.path.dirname(os.path.dirname(_here)))  # noqa: PTH120


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    place = _PLACES.get(name, "library.calls")
    return getattr(import_module(f"{__name__}.{place}"), name)
