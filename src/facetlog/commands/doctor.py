"""`facetlog doctor`: what is there of what facetlog needs, and the way to what is missing."""

import json
from typing import TYPE_CHECKING

import typer

from facetlog.commands.shared import YES, AsJson, command
from facetlog.errors import EngineError

if TYPE_CHECKING:
    from facetlog.doctor import Finding

__all__ = ["doctor_command"]

SCHEMA = "facetlog-doctor/1"


@command
def doctor_command(as_json: AsJson = False) -> int:
    """Says what facetlog needs, and what of it is there.

    Exit code 0: all that recognition needs, 3: something of it is missing.
    """
    from facetlog.doctor import Standing, findings
    from facetlog.terminal import printable

    found = tuple(findings())
    if as_json:
        typer.echo(json.dumps({"schema": SCHEMA, "findings": [each.to_json() for each in found]}))
    else:
        typer.echo("\n".join(map(printable, _lines(found))))
    missing = any(each.standing is Standing.MISSING for each in found)
    return EngineError.exit_code if missing else YES


def _lines(found: "tuple[Finding, ...]") -> list[str]:
    wide = max(len(each.name) for each in found)
    standing = max(len(each.standing) for each in found)
    return [f"{each.name:<{wide}}  {each.standing:<{standing}}  {each.detail}" for each in found]
