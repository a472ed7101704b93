"""A mesh or cloud file that is being read: limits, checks, and one wording for its errors."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError

DECIMAL_COMMA = re.compile(rb"^[-+]?\d*,\d+(?:[eE][-+]?\d+)?$")
# Lines are quoted up to so many characters.
QUOTED = 60


@dataclass(frozen=True, slots=True)
class Limits:
    """Sizes above which files are refused.

    A binary STL of 5 million triangles, which must work, has 250 MB; a laser scan of a building has
    50 million points, whose arrays take 2.4 GB.
    """

    size_bytes: int = 4 << 30
    triangles: int = 20_000_000
    points: int = 50_000_000


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True, slots=True)
class ShapeFile:
    """A file, its `kind` ("mesh" or "cloud"), and its limits."""

    path: Path
    kind: str
    limits: Limits

    @property
    def name(self) -> str:
        """Name in messages."""
        return self.path.name

    @property
    def remedy(self) -> str:
        """Way out of a file that is too large."""
        return "thin the cloud" if self.kind == "cloud" else "reduce the mesh"

    @contextmanager
    def translate_errors(self) -> Iterator[None]:
        """Raise InputError for a file that cannot be opened, or does not fit into memory."""
        try:
            yield
        except MemoryError as exc:
            raise self.error(f"does not fit into memory; {self.remedy}") from exc
        except OSError as exc:
            raise self.error(f"cannot be read ({exc.strerror}); check the path") from exc

    def check_size(self) -> None:
        """Raise InputError for what is no file, empty or too large; OSError where it is missing."""
        size = self.path.stat().st_size
        if not self.path.is_file():
            raise self.error(f"is no file; give a {self.kind}")
        if size == 0:
            raise self.error(f"is empty; export the {self.kind} again")
        if size > self.limits.size_bytes:
            raise self.error(f"has {size} bytes, more than {self.limits.size_bytes}; {self.remedy}")

    def check_triangles(self, count: int) -> None:
        """Raise InputError where a file has more triangles than the limit."""
        if count > self.limits.triangles:
            raise self.error(
                f"has more than {self.limits.triangles} triangles; reduce or split the mesh"
            )

    def check_points(self, count: int) -> None:
        """Raise InputError where a file has more points than the limit."""
        if count > self.limits.points:
            raise self.error(f"has {count} points, more than {self.limits.points}; {self.remedy}")

    def error(self, what: str) -> InputError:
        """Return the error of a file that cannot be used, and the way out."""
        return InputError(f"{self.name}: {what}")

    def make_truncation_error(self, what: str) -> InputError:
        """Return the error of a file that ends too early."""
        return self.error(f"{what}; it is truncated: export or copy it again")

    def make_false_claim_error(self, claim: str) -> InputError:
        """Return the error of a header whose counts are larger than the file."""
        return self.make_truncation_error(f"claims {claim}, more than it holds")

    def make_inconsistency_error(self, what: str) -> InputError:
        """Return the error of a file whose counts or indices contradict its contents."""
        return self.error(f"{what}; it is truncated or inconsistent, export it again")

    def make_bad_row_error(self, number: int, row: bytes, what: str) -> InputError:
        """Return the error of a row, in line `number`, that is not the numbers of a `what`."""
        place = quote_line(number, row)
        if any(DECIMAL_COMMA.match(word) for word in row.split()):
            return self.error(f"{place}: has decimal commas; export with decimal points")
        if b"," in row:
            return self.error(f"{place}: has commas between numbers; export with blanks")
        return self.make_inconsistency_error(f"{place}: is no {what}")


def quote_line(number: int, row: bytes) -> str:
    """Return the place and the text of a line, as a message begins."""
    shown = row.decode("utf-8", "replace").strip()
    return f"line {number}: {shown:.{QUOTED}}"
