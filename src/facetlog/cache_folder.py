"""Cache folders: files that are only ever copies of what can be made again.

Whatever is wrong with a file, the folder or the disk, what is kept there is made again. Each file
has a SHA-256 over all of it and its name, checked before anybody believes a byte.
"""

import hashlib
import logging
import math
import os
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path

__all__ = [
    "MOST_BYTES",
    "PART",
    "CacheFolder",
    "cache_folder",
    "get_default_folder",
    "replace_file",
]

MOST_BYTES = 1 << 30
"""Size limit of the user's cache: some 4,000 meshes with their facts (250 kB each)."""

SHARE_OF_FREE = 0.5
"""Of a disk's free room that a folder may take which the user names: as much is left."""

LARGEST_BYTES = MOST_BYTES // 4
"""One file must not push out all others."""

SHARE_UNCHECKED = 1 / 16
"""Of the limit, what a process writes before it looks again how much is there: a look at
thousands of files takes longer than to write one."""

STALE_SECONDS = 3600.0
"""A half-written file of this age has nobody left who writes it."""

OFF = "off"
"""The value of FACETLOG_CACHE that forbids any cache."""

SUFFIXES = (".scene", ".shape", ".facts")
"""Of compiled scenes and models, of scenes made of meshes and clouds, and of their facts."""

PART = ".part"
"""Of files that are being written."""

# A file: the magic, the digest of its name and all that follows, the content.
_MAGIC = b"facetlog cache 1\n"
_DIGEST_BYTES = hashlib.sha256().digest_size
_WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH

_LOG = logging.getLogger(__name__)


def get_default_folder(name: str = "scenes") -> Path:
    """Return facetlog/NAME in XDG_CACHE_HOME, which must be absolute, or in ~/.cache."""
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path("~/.cache").expanduser()) / "facetlog" / name


def cache_folder(name: str, folder: Path | None = None) -> Path | None:
    """Return that folder or NAME in the user's cache, made if need be; None for no cache at all.

    Raise OSError or RuntimeError (no home directory) for one that is not the user's alone.
    """
    if os.environ.get("FACETLOG_CACHE", "").lower() == OFF:
        return None
    return _make_private_folder(get_default_folder(name) if folder is None else Path(folder))


def _make_private_folder(folder: Path) -> Path:
    """Return the folder, made if need be; raises OSError if it is not ours alone to write."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.stat()
    if status.st_uid != os.geteuid():
        raise PermissionError(f"{folder} belongs to another user")
    if status.st_mode & _WRITABLE_BY_OTHERS:
        raise PermissionError(f"{folder} can be written by other users (chmod go-w would do)")
    return folder


class CacheFolder:
    """The folder of kept scenes; each method that fails says so, and none of them raises.

    The default folder is made for its owner alone. One that another user owns or may write to is
    not used, and a warning is logged once. `FACETLOG_CACHE=off` in the environment turns it off.
    """

    def __init__(self, folder: Path | None = None, *, most_bytes: int | None = None) -> None:
        self._most_bytes = MOST_BYTES if most_bytes is None else most_bytes
        self._unchecked = math.inf  # how much is there is not known yet
        self.folder: Path | None = None
        try:
            self.folder = cache_folder("scenes", folder)
            if self.folder is not None and folder is not None and most_bytes is None:
                disk = os.statvfs(self.folder)
                free = disk.f_bavail * disk.f_frsize + self.measure()[1]
                self._most_bytes = max(MOST_BYTES, int(SHARE_OF_FREE * free))
        except (OSError, RuntimeError) as exc:  # no home directory is a RuntimeError
            self.folder = None
            _LOG.warning("scenes are not cached: %s", exc)

    def place(self, name: str) -> Path | None:
        """Return the file of that name; None if there is no cache."""
        return None if self.folder is None else self.folder / name

    def read(self, path: Path | None) -> bytes | None:
        """Return the content of a file; None if it is not there or not exactly what was written for
        it.
        """
        if path is None:
            return None
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            with os.fdopen(descriptor, "rb") as file:
                status = os.fstat(descriptor)
                if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid():
                    return None
                head = file.read(len(_MAGIC) + _DIGEST_BYTES)
                content = file.read()
        except OSError:
            return None
        if head != _MAGIC + _compute_digest(path, content):
            return None
        return content

    def mark_used(self, path: Path) -> None:
        """Let the file stay longer than those that were used before."""
        try:
            os.utime(path)
        except OSError as exc:
            _LOG.info("%s: cannot be marked as used: %s", path, exc)

    def write(self, path: Path | None, content: bytes) -> bool:
        """Return whether the content was written to the file, for which others may have to go."""
        size = len(_MAGIC) + _DIGEST_BYTES + len(content)
        if path is None or size > min(LARGEST_BYTES, self._most_bytes):
            return False
        try:
            replace_file(path, _MAGIC + _compute_digest(path, content) + content)
            self._unchecked += size
            if self._unchecked >= SHARE_UNCHECKED * self._most_bytes:
                self._evict_oldest(path.parent)
                self._unchecked = 0
        except OSError as exc:
            _LOG.info("%s: cannot be written: %s", path, exc)
            return False
        return True

    def measure(self) -> tuple[int, int]:
        """Return the number of files in the folder, and their bytes."""
        files = [] if self.folder is None else _list_files(self.folder)
        return len(files), sum(size for _, size, _ in files)

    def clear(self) -> None:
        """Delete all files, and those that are half written."""
        if self.folder is None:
            return
        for _, _, path in _list_files(self.folder):
            _delete_quietly(Path(path))
        for part in self.folder.glob(f"*{PART}"):
            _delete_quietly(part)

    def _evict_oldest(self, folder: Path) -> None:
        """Delete half-written files, and those not used for longest until the rest fits."""
        for path in folder.glob(f"*{PART}"):
            with suppress(FileNotFoundError):  # another process deleted it, or it is whole now
                if time.time() - path.stat().st_mtime > STALE_SECONDS:
                    path.unlink()
        files = _list_files(folder)
        total = sum(size for _, size, _ in files)
        for _, size, name in sorted(files):
            if total <= self._most_bytes:
                break
            _delete_quietly(Path(name))
            total -= size


def _list_files(folder: Path) -> list[tuple[int, int, str]]:
    """Return when each kept file was used last (ns), its bytes and its path."""
    files = []
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith(SUFFIXES):
                try:
                    status = entry.stat(follow_symlinks=False)
                except OSError:  # another process deleted it
                    continue
                files.append((status.st_mtime_ns, status.st_size, entry.path))
    return files


def _compute_digest(path: Path, content: bytes) -> bytes:
    total = hashlib.sha256(f"{path.name}\n".encode())
    total.update(content)
    return total.digest()


def replace_file(path: Path, content: bytes) -> None:
    """Write the file whole or not at all; of two who do so at once, the last one stays."""
    descriptor, part = tempfile.mkstemp(suffix=PART, dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        Path(part).replace(path)
    except BaseException:
        _delete_quietly(Path(part))
        raise


def _delete_quietly(path: Path) -> None:
    try:
        path.unlink()
    except OSError:
        return  # it is gone, or the folder is read-only: no harm
