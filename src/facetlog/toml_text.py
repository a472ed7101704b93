"""TOML that a person wrote."""

import tomllib

from facetlog.errors import InputError

__all__ = ["parse_toml_fields"]


def parse_toml_fields(text: str, where: str) -> dict[str, object]:
    """Parse a TOML text of the file `where`; raise InputError if it is none."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as exc:  # its message ends with line and column
        raise InputError(f"{where}: not TOML: {exc}: correct it there") from exc
    except (RecursionError, ValueError) as exc:  # nested or long beyond what Python reads
        raise InputError(f"{where}: not TOML that can be read: too deep or too long") from exc
