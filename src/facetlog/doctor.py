"""What facetlog needs and what of it is there: SWI-Prolog, packages, extras, cache, machine."""

import importlib.metadata
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from facetlog import __version__
from facetlog.errors import FacetlogError

__all__ = ["Finding", "Standing", "findings"]

_NAME = re.compile(r"[A-Za-z0-9_.-]+")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")
FOR_DEVELOPERS = ("dev", "docs")


class Standing(StrEnum):
    """How something stands: there, not there but not needed by all, or missing."""

    GOOD = "ok"
    ABSENT = "not there"
    MISSING = "MISSING"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at: its name, how it stands, and its version or the way out."""

    name: str
    standing: Standing
    detail: str

    def to_json(self) -> dict[str, str]:
        """The same as plain data."""
        return {"name": self.name, "standing": self.standing.value, "detail": self.detail}


def findings() -> Iterator[Finding]:
    """All that matters for whether facetlog runs here, one after the other."""
    version = ".".join(map(str, sys.version_info[:3]))
    yield Finding("facetlog", Standing.GOOD, f"{__version__}, Python {version}")
    yield _prolog()
    if not _requirements():
        yield Finding("packages", Standing.ABSENT, "facetlog is not installed: pip install -e .")
    for name in _needed():
        yield _package(name)
    for extra, names in _extras().items():
        yield _extra(extra, names)
    yield _cache()
    yield _machine()


def _prolog() -> Finding:
    """Whether a knowledge base opens, which takes SWI-Prolog and what calls it."""
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


def _requirements() -> list[str]:
    """What facetlog's metadata name; nothing where it runs from a checkout alone."""
    try:
        return importlib.metadata.requires("facetlog") or []
    except importlib.metadata.PackageNotFoundError:
        return []


def _needed() -> tuple[str, ...]:
    """The packages that facetlog cannot do without."""
    return tuple(_name(line) for line in _requirements() if _EXTRA.search(line) is None)


def _extras() -> dict[str, tuple[str, ...]]:
    """The packages of each extra but those for developers."""
    found: dict[str, tuple[str, ...]] = {}
    for line in _requirements():
        extra = _EXTRA.search(line)
        # [all] is of the other extras, each of which is listed.
        of_others = _name(line) == "facetlog"
        if extra is not None and extra[1] not in FOR_DEVELOPERS and not of_others:
            found[extra[1]] = (*found.get(extra[1], ()), _name(line))
    return found


def _name(requirement: str) -> str:
    match = _NAME.match(requirement)
    return match[0] if match else requirement


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _package(name: str) -> Finding:
    version = _version(name)
    if version is None:
        return Finding(name, Standing.MISSING, f"pip install {name}")
    return Finding(name, Standing.GOOD, version)


def _extra(extra: str, names: tuple[str, ...]) -> Finding:
    there = {name: _version(name) for name in names}
    if None in there.values():
        return Finding(f"[{extra}]", Standing.ABSENT, f"pip install 'facetlog[{extra}]'")
    known = ", ".join(f"{name} {version}" for name, version in there.items())
    return Finding(f"[{extra}]", Standing.GOOD, known)


def _cache() -> Finding:
    """The folder of compiled scenes; without one they are loaded anew each time."""
    from facetlog.kb.loading.scene_cache import SceneCache, default_folder

    folder = SceneCache().folder
    if folder is None:
        reason = f"off by FACETLOG_CACHE, or {default_folder()} cannot be used"
        return Finding("cache", Standing.ABSENT, reason)
    return Finding("cache", Standing.GOOD, f"{folder}, {_size(folder)}")


def _size(folder: Path) -> str:
    files = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
    return f"{len(files)} files, {sum(files) / 1e6:.1f} MB"


def _machine() -> Finding:
    from facetlog.batch.memory import memory_mb

    cores = len(os.sched_getaffinity(0))
    return Finding("machine", Standing.GOOD, f"{cores} cores, {memory_mb() / 1024:.1f} GB")
