"""`facetlog doctor`: tell which of the things that facetlog needs are installed."""

import json
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Annotated

import typer

from facetlog import __version__
from facetlog.commands.shared import YES, AsJson, command
from facetlog.errors import EngineError, FacetlogError
from facetlog.terminal import printable

__all__ = ["doctor_command"]

SCHEMA = "facetlog-doctor/1"

_NAME = re.compile(r"[A-Za-z0-9_.-]+")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")
FOR_DEVELOPERS = ("dev", "docs")


class Standing(StrEnum):
    """Whether something is there, absent but not needed by everybody, or missing."""

    GOOD = "ok"
    ABSENT = "not there"
    MISSING = "MISSING"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at, with its version or the way out."""

    name: str
    standing: Standing
    detail: str


@command
def doctor_command(
    clear_cache: Annotated[
        bool, typer.Option("--clear-cache", help="Delete kept scenes and facts first.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Check whether everything that facetlog needs is installed.

    Exit code 0: all that recognition needs is there, 3: something is missing.
    """
    if clear_cache:
        from facetlog.cache_folder import CacheFolder

        CacheFolder().clear()
    found = tuple(_find_all())
    if as_json:
        typer.echo(json.dumps({"schema": SCHEMA, "findings": list(map(asdict, found))}))
    else:
        wide = max(len(each.name) for each in found)
        standing = max(len(each.standing) for each in found)
        for each in found:
            line = f"{each.name:<{wide}}  {each.standing:<{standing}}  {each.detail}"
            typer.echo(printable(line))
    missing = any(each.standing is Standing.MISSING for each in found)
    return EngineError.exit_code if missing else YES


def _find_all() -> Iterator[Finding]:
    version = ".".join(map(str, sys.version_info[:3]))
    yield Finding("facetlog", Standing.GOOD, f"{__version__}, Python {version}")
    yield _check_prolog()
    if not _list_requirements():
        yield Finding("packages", Standing.ABSENT, "facetlog is not installed: pip install -e .")
    for name in _list_needed():
        version_found = _find_version(name)
        if version_found is None:
            yield Finding(name, Standing.MISSING, f"pip install {name}")
        else:
            yield Finding(name, Standing.GOOD, version_found)
    for extra, names in _list_extras().items():
        yield _check_extra(extra, names)
    yield _check_cache()
    yield _check_machine()


def _check_prolog() -> Finding:
    """Try to open a knowledge base, which takes SWI-Prolog and what calls it."""
    try:
        from facetlog.kb.engine.engine import start
        from facetlog.kb.recognize import open_knowledge_base

        with open_knowledge_base() as base:
            models = len(base.models)
        version = ".".join(map(str, start().version))
    except FacetlogError as exc:
        return Finding("SWI-Prolog", Standing.MISSING, str(exc))
    except Exception as exc:  # of a package that is broken: the next lines say which
        return Finding("SWI-Prolog", Standing.MISSING, f"cannot be tried: {exc}")
    return Finding("SWI-Prolog", Standing.GOOD, f"{version}, {models} built-in models load")


def _list_requirements() -> list[str]:
    """Return the requirements in facetlog's metadata; none where it runs from a checkout alone."""
    from importlib import metadata  # loaded on demand: it is slow to load

    try:
        return metadata.requires("facetlog") or []
    except metadata.PackageNotFoundError:
        return []


def _list_needed() -> tuple[str, ...]:
    """Return the packages that facetlog cannot do without."""
    return tuple(_parse_name(line) for line in _list_requirements() if _EXTRA.search(line) is None)


def _list_extras() -> dict[str, tuple[str, ...]]:
    """Return the packages of each extra but those for developers."""
    found: dict[str, tuple[str, ...]] = {}
    for line in _list_requirements():
        extra = _EXTRA.search(line)
        # [all] is of the other extras, each of which is listed.
        of_others = _parse_name(line) == "facetlog"
        if extra is not None and extra[1] not in FOR_DEVELOPERS and not of_others:
            found[extra[1]] = (*found.get(extra[1], ()), _parse_name(line))
    return found


def _parse_name(requirement: str) -> str:
    match = _NAME.match(requirement)
    return match[0] if match else requirement


def _find_version(name: str) -> str | None:
    from importlib import metadata  # loaded on demand: it is slow to load

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _check_extra(extra: str, names: tuple[str, ...]) -> Finding:
    there = {name: _find_version(name) for name in names}
    if None in there.values():
        return Finding(f"[{extra}]", Standing.ABSENT, f"pip install 'facetlog[{extra}]'")
    known = ", ".join(f"{name} {version}" for name, version in there.items())
    return Finding(f"[{extra}]", Standing.GOOD, known)


def _check_cache() -> Finding:
    """Look for the folder of kept scenes; without one they are made anew each time."""
    from facetlog.cache_folder import MOST_BYTES, CacheFolder, get_default_folder

    kept = CacheFolder()
    if kept.folder is None:
        reason = f"off by FACETLOG_CACHE, or {get_default_folder()} cannot be used"
        return Finding("cache", Standing.ABSENT, reason)
    count, size = kept.measure()
    detail = f"{kept.folder}, {count} files, {size / 1e6:.1f} MB of at most {MOST_BYTES / 1e6:.0f}"
    return Finding("cache", Standing.GOOD, f"{detail} (--clear-cache deletes them)")


def _check_machine() -> Finding:
    from facetlog.batch.memory import memory_mb

    cores = len(os.sched_getaffinity(0))
    return Finding("machine", Standing.GOOD, f"{cores} cores, {memory_mb() / 1024:.1f} GB")
