"""The built-in models as Prolog, compiled from rules/NAME.model at first use."""

import atexit
import hashlib
import logging
import os
import shutil
import tempfile
import time
from functools import cache
from pathlib import Path

from facetlog.cache_folder import cache_folder, replace_file
from facetlog.kb.engine.engine import house

__all__ = ["BUILTIN_MODELS", "builtin_rules"]

BUILTIN_MODELS = tuple(sorted(path.stem for path in house("rules").glob("*.model")))

MADE_FROM = ("rules/*.model", "rules/*.pl", "grammar/**/*.py")
"""Files that the compiled text follows from."""

MOST_KEPT = 8
"""Folders of other versions of these files that stay in the cache."""
KEPT_S = 24 * 3600.0
"""Seconds that a folder stays after its last use: another process may still load from it."""

_LOG = logging.getLogger(__name__)


def builtin_rules() -> Path:
    """Return a folder with the Prolog file NAME.pl of each built-in model.

    It is in the user's cache, and compiled if it is not there yet; else a temporary folder of this
    process. Several processes may make it at once: each file is there whole or not at all.
    """
    folder = _folder()
    missing = [name for name in BUILTIN_MODELS if not (folder / f"{name}.pl").is_file()]
    if missing:
        # To load the language and to compile all models takes half a second.
        from facetlog.grammar.analysis import analyse
        from facetlog.grammar.compile import compiled

        for name in missing:
            model = analyse(house("rules") / f"{name}.model")
            replace_file(folder / f"{name}.pl", compiled(model).prolog.encode())
    return folder


@cache
def _folder() -> Path:
    """Return the folder of this process: Prolog loads a module from one place only."""
    total = hashlib.sha256()
    root = house("rules").parent
    for pattern in MADE_FROM:
        for path in sorted(root.glob(pattern)):
            total.update(path.read_bytes())
    try:
        rules = cache_folder("rules")
        if rules is not None:
            folder = rules / total.hexdigest()
            folder.mkdir(mode=0o700, exist_ok=True)
            os.utime(folder)
            used = sorted((made.stat().st_mtime, made) for made in rules.iterdir())
            for last, old in used[:-MOST_KEPT]:
                if time.time() - last > KEPT_S:
                    shutil.rmtree(old, ignore_errors=True)
            with tempfile.TemporaryFile(dir=folder):  # whether it can be written to
                return folder
    except (OSError, RuntimeError) as exc:
        _LOG.info("built-in models are compiled without a cache: %s", exc)
    temporary = tempfile.TemporaryDirectory(prefix="facetlog-rules-")
    atexit.register(temporary.cleanup)
    return Path(temporary.name)
