"""Scenes of shape files, and their facts, that are kept from one run to the next.

To make the scene of a mesh takes a hundred times what it takes to read it again. It is kept under a
digest of all that it follows from: the content of the file, the options, and the code that makes
it; and it counts only while the files that were read beside it (a glTF's buffers) are the same.
Facts are kept column by column; kinds that are asked for later are added. Nothing is executed.
"""

import hashlib
import json
import logging
import zlib
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facetlog import __version__
from facetlog.batch.content import hash_content
from facetlog.cache_folder import CacheFolder
from facetlog.errors import InputError
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, ON_DEMAND, Fact
from facetlog.perception.facts.facts_code import SHAPES_CODE, facts_code_hash
from facetlog.perception.facts.named_rows import FactColumns, convert_to_rows
from facetlog.perception.shapes.shape_options import SUFFIXES, ShapeOptions, is_scene_file
from facetlog.safe_read import Signature, record_reads

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene

__all__ = ["KeptScene", "SceneKeeper", "Summary", "read_stated"]

LAYOUT = 1
"""Of the files: another number for another layout."""

COMPRESSION = 1
"""zlib's level: a scene becomes a fourth; the next levels take twice the time for a tenth."""

AMBIGUOUS = "points3D.txt"
"""Of a COLMAP model: what is read depends on whether there is a points3D.bin, too."""

NAME, WHOLE, FLOAT = "<u4", "<i8", "<f8"
"""Columns of facts: places in the table of names, whole numbers, floats."""

SHAPE, FACTS = ".shape", ".facts"

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary of a scene, as rows have it beside verdicts."""

    faces: int
    up: tuple[float, float, float] | None
    metric: bool
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, scene: "Scene") -> "Summary":
        """Return the summary of a scene."""
        up = None if scene.up is None else tuple(scene.up.tolist())
        return cls(len(scene.faces), up, scene.metric, scene.warnings)


class SceneKeeper:
    """Reads shape files, and keeps what was made of them in a folder, the user's cache if not
    given.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._files = CacheFolder(folder)

    def open(self, path: Path, options: ShapeOptions, data: bytes | None = None) -> "KeptScene":
        """Return the scene of a file, which is read when it is asked for.

        `data` is the content of a scene file that was read; then the options count for it, too.
        """
        return KeptScene(path, options, self._files, data)


class KeptScene:
    """The scene of a shape file, as `read_shape` or `read_stated` returns it, with its facts.

    What is asked for raises InputError for a file that cannot be read or has no shape, has too many
    faces for facts, or changes while it is read.
    """

    def __init__(
        self, path: Path, options: ShapeOptions, files: CacheFolder, data: bytes | None = None
    ) -> None:
        self._path, self._options, self._files, self._data = path, options, files, data
        self._is_scene = data is not None or is_scene_file(str(path))
        self._keeps = True  # until a file is seen to change
        self._beside: dict[str, str] = {}
        self._summary: Summary | None = None
        self._scene: Scene | None = None
        self._columns: FactColumns = {}

    @cached_property
    def _hashed(self) -> tuple[str, Signature | None]:
        if self._data is not None:
            return hashlib.sha256(self._data).hexdigest(), None
        with record_reads() as reads:
            return hash_content(self._path), reads[self._path]

    @property
    def sha256(self) -> str:
        """SHA-256 of the file's content, as hexadecimal digits."""
        return self._hashed[0]

    @cached_property
    def _digest(self) -> str | None:
        """Digest of what the scene follows from, but for files beside; None if nothing is kept."""
        if self._files.folder is None or self._path.is_dir() or self._path.name == AMBIGUOUS:
            return None
        if self._data is None and self._path.suffix.lower() not in SUFFIXES:
            return None  # it is said so where it is read
        parts = [
            LAYOUT,
            __version__,
            facts_code_hash(patterns=SHAPES_CODE),
            self._path.absolute().parts[-2:],  # a scene is named after its file or folder
            self.sha256,
            None if self._is_scene and self._data is None else repr(self._options),
        ]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()

    @property
    def key(self) -> str | None:
        """Key for what else follows from the scene; None if nothing is kept."""
        if not self._is_scene and self._digest is not None:
            _ = self.summary  # by which the files beside are known
        if self._digest is None or not self._keeps:
            return None
        return hashlib.sha256(json.dumps([self._digest, self._beside]).encode()).hexdigest()

    @property
    def summary(self) -> Summary:
        """Summary of the scene, as rows have it beside verdicts."""
        if self._summary is None:
            self._read(SHAPE)
        return self._summary or Summary.of(self.scene())

    def scene(self) -> "Scene":
        """Return the scene."""
        if self._scene is None:
            self._scene = self._read_scene() or self._make_scene()
            self._summary = Summary.of(self._scene)
        return self._scene

    def has_facts(self, kinds: Collection[str]) -> bool:
        """Return whether the facts of these kinds are kept."""
        if not self._columns and (kept := self._read(FACTS)) is not None:
            self._columns = _decode_columns(kept[0], zlib.decompress(kept[1]))
        return self._columns.keys() >= _find_known(kinds)

    def facts(self, kinds: Collection[str]) -> FactColumns:
        """Return the facts of these kinds, as `fact_columns` does."""
        wanted = _find_known(kinds)
        if not self.has_facts(wanted):
            from facetlog.perception.facts.all_facts import fact_columns

            scene = self.scene()
            self._columns |= fact_columns(scene, wanted - self._columns.keys())
            self._write(FACTS, *_encode_columns(self._columns))
        ordered = (kind.functor for kind in FACT_SCHEMA)
        return {functor: self._columns[functor] for functor in ordered if functor in wanted}

    def facts_on_demand(self) -> tuple[Fact, ...]:
        """Return the facts that are made on demand, as perception's `facts_on_demand` does."""
        try:
            columns = self.facts(ON_DEMAND)
        except (InputError, MemoryError):
            raise
        except Exception:  # a kind fails: those that do not
            from facetlog.perception.facts.all_facts import facts_on_demand

            return facts_on_demand(self.scene())
        return tuple(
            Fact(functor, row) for functor, own in columns.items() for row in convert_to_rows(own)
        )

    def _read_scene(self) -> "Scene | None":
        kept = None if self._is_scene else self._read(SHAPE)
        if kept is None:
            return None
        from facetlog.perception.surfaces.scene_file import decode_scene

        try:
            return decode_scene(zlib.decompress(kept[1]))
        except InputError as exc:
            _LOG.info("%s: the scene that was kept cannot be read: %s", self._path, exc)
            return None

    def _make_scene(self) -> "Scene":
        from facetlog.perception.facts.most_faces import check_face_count
        from facetlog.perception.shapes.read_shape import read_shape, stated
        from facetlog.perception.surfaces.scene_file import decode_scene

        keeps = self._digest is not None
        with record_reads() as reads:
            if self._data is None:
                scene = read_shape(self._path, self._options)
            else:
                scene = stated(decode_scene(self._data, str(self._path)), self._options)
        check_face_count(scene, self._path)
        self._columns = {}  # of other files beside, if they were changed meanwhile
        self._summary = Summary.of(scene)
        self._keeps = keeps and (self._data is not None or self._is_unchanged(reads))
        if not self._is_scene:
            self._write_scene(scene)
        return scene

    def _is_unchanged(self, reads: Mapping[Path, Signature]) -> bool:
        """Return whether what was hashed is what was read; remember what was read beside the file.

        Raise InputError if the file is another by now.
        """
        own = self._path.resolve()
        beside = [path for path in reads if path.resolve() != own]
        named = {path: _find_relative(path, self._path.parent) for path in beside}
        if None in named.values() or (beside and self._path.is_symlink()):
            return False  # it may come to another folder, with other files
        with record_reads() as after:
            self._beside = {str(name): hash_content(path) for path, name in named.items()}
            if hash_content(self._path) != self.sha256:
                raise InputError(f"{self._path}: was changed while it was read. Read it again.")
        same = all(after[path] == reads[path] for path in beside)
        return same and after[self._path] == self._hashed[1]

    def _write_scene(self, scene: "Scene") -> None:
        from facetlog.perception.surfaces.scene_file import encode_scene

        try:
            content = encode_scene(scene).encode()
        except ValueError as exc:  # a number that is not finite
            _LOG.info("%s: the scene is not kept: %s", self._path, exc)
            return
        self._write(SHAPE, {}, content)

    def _read(self, suffix: str) -> tuple[dict[str, Any], bytes] | None:
        """Return head and body of what was kept, while the files beside are the same."""
        if self._digest is None or not self._keeps:
            return None
        path = self._files.place(self._digest + suffix)
        content = self._files.read(path)
        if path is None or content is None:
            return None
        first, _, body = content.partition(b"\n")
        head = json.loads(first)
        beside = head.pop("beside")
        if beside and self._path.is_symlink():
            return None
        if any(_hash_or_none(self._path.parent / name) != its for name, its in beside.items()):
            return None
        if beside != self._beside:
            self._columns = {}
        said = head.pop("summary")
        up = None if said["up"] is None else tuple(said["up"])
        self._summary = Summary(said["faces"], up, said["metric"], tuple(said["warnings"]))
        self._beside = beside
        self._files.mark_used(path)
        return head, body

    def _write(self, suffix: str, head: dict[str, Any], body: bytes) -> None:
        if self._digest is None or not self._keeps or self._summary is None:
            return
        said = {"beside": self._beside, "summary": asdict(self._summary), **head}
        content = json.dumps(said).encode() + b"\n" + zlib.compress(body, COMPRESSION)
        self._files.write(self._files.place(self._digest + suffix), content)


def _hash_or_none(path: Path) -> str | None:
    try:
        return hash_content(path)
    except InputError:
        return None


def _find_relative(path: Path, folder: Path) -> Path | None:
    """Return the path from a folder to what is in it, as it is written; None for what is not."""
    path, own = path.absolute(), (folder.absolute(), folder.resolve())
    return next((path.relative_to(each) for each in own if path.is_relative_to(each)), None)


def _find_known(kinds: Collection[str]) -> set[str]:
    return {kind.functor for kind in FACT_SCHEMA if kind.functor in kinds}


def _encode_columns(columns: FactColumns) -> tuple[dict[str, Any], bytes]:
    """Return what the bytes are, and the bytes of all columns, one after the other.

    >>> facts = {"area": (["f1", "f2"], np.array([0.5, 0.1])), "gap": (), "corner": (["f1"], [3])}
    >>> _decode_columns(*_encode_columns(facts))
    {'area': (['f1', 'f2'], array([0.5, 0.1])), 'gap': (), 'corner': (['f1'], [3])}
    """
    names: dict[str, int] = {}
    parts: list[bytes] = []
    values: NDArray[Any]
    layout: dict[str, list[tuple[str, int]]] = {}
    for functor, own in columns.items():
        layout[functor] = []
        for column in own:
            if isinstance(column, np.ndarray):
                kind, values = FLOAT, column.astype(FLOAT)
            elif set(map(type, column)) == {int}:
                kind, values = WHOLE, np.array(column, WHOLE)
            else:
                places = [names.setdefault(str(name), len(names)) for name in column]
                kind, values = NAME, np.array(places, NAME)
            layout[functor].append((kind, len(column)))
            parts.append(values.tobytes())
    return {"names": list(names), "columns": layout}, b"".join(parts)


def _decode_columns(head: Mapping[str, Any], body: bytes) -> FactColumns:
    """Return the columns that `_encode_columns` was given."""
    names = np.array(head["names"], dtype=np.object_)
    start = 0

    def decode(kind: str, count: int) -> Any:
        nonlocal start
        values = np.frombuffer(body, kind, count, start)
        start += values.nbytes
        if kind == FLOAT:
            return values
        return values.tolist() if kind == WHOLE else names[values].tolist()

    return {
        functor: tuple(decode(kind, count) for kind, count in own)
        for functor, own in head["columns"].items()
    }


def read_stated(path: Path, options: ShapeOptions) -> "Scene":
    """Return the scene of a file as perception's `read_stated` does, kept in the user's cache."""
    from facetlog.perception.shapes.read_shape import stated

    scene = SceneKeeper().open(path, options).scene()
    return stated(scene, options) if is_scene_file(str(path)) else scene
