"""The errors a reader can do something about; each message is one line that names the way out.

Every package may import this module, which imports nothing.
"""

__all__ = [
    "CalibrationError",
    "DeviceError",
    "DeviceTimeout",
    "EngineError",
    "FacetlogError",
    "InconsistentViewsError",
    "InputError",
    "QueryError",
    "RuleSyntaxError",
    "make_missing_extra_error",
]


class FacetlogError(Exception):
    """Root of all errors of facetlog: its message is one line that names the way out."""

    exit_code = 2
    """Exit code of the command line."""


class InputError(FacetlogError):
    """A file or folder given by the user cannot be used as it is."""


class CalibrationError(InputError):
    """A camera or a pose is missing, incomplete or impossible."""


class InconsistentViewsError(InputError):
    """The pictures and the poses do not belong together."""


class RuleSyntaxError(InputError):
    """A model file cannot be read; the message names file and line."""


class QueryError(InputError):
    """A question cannot be asked: `text` is the question, from `start` to `end` is the fault."""

    def __init__(self, message: str, *, text: str = "", start: int = 0, end: int = 0) -> None:
        super().__init__(message)
        self.text, self.start, self.end = text, start, end


class EngineError(FacetlogError):
    """SWI-Prolog is missing, too old, or failed."""

    exit_code = 3


class LimitError(EngineError):
    """A question reached its limit of time, inferences or memory."""


class DeviceError(FacetlogError):
    """A robot, its camera head or its camera cannot be reached, or does not obey a command."""

    exit_code = 3


class DeviceTimeout(DeviceError, TimeoutError):  # noqa: N818 - as TimeoutError, which it is
    """A device did not answer, or did not get done, in the time it was given."""


def make_missing_extra_error(what: str, package: str, extra: str) -> InputError:
    """Return the error for a package that is not installed, which names the extra that brings it.

    >>> str(make_missing_extra_error("tables", "pandas", "tables"))
    "tables need pandas: pip install 'facetlog[tables]'"
    """
    needs = "need" if what.endswith("s") else "needs"
    return InputError(f"{what} {needs} {package}: pip install 'facetlog[{extra}]'")
