"""Kept scenes: what is read again is what would be made, whatever happened to files."""

import errno
import json
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog import cache_folder
from facetlog.cache_folder import CacheFolder
from facetlog.errors import InputError
from facetlog.kept_scenes import KeptScene, SceneKeeper
from facetlog.perception.facts.all_facts import fact_columns, facts_on_demand
from facetlog.perception.facts.fact_schema import ON_DEMAND
from facetlog.perception.shapes import read_shape as reader
from facetlog.perception.shapes.shape_options import ShapeOptions
from facetlog.perception.surfaces.scene_file import encode_scene
from facetlog.python_process import make_importing_environment

Z = ShapeOptions(up=(0.0, 0.0, 1.0), unit="m")
KINDS = {"thing", "area", "angle", "corner", "upward"}


@pytest.fixture
def keeper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SceneKeeper:
    monkeypatch.delenv("FACETLOG_CACHE", raising=False)
    return SceneKeeper(tmp_path / "kept")


@pytest.fixture
def box(tmp_path: Path) -> Path:
    return write_box(tmp_path / "box.ply")


def write_box(path: Path, height: float = 1.0) -> Path:
    path.parent.mkdir(exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # of trimesh's own files
        trimesh.creation.box((0.4, 0.3, height)).export(path)
    return path


def describe(kept: KeptScene, kinds: set[str] = KINDS) -> str:
    """Return the facts, the summary and the scene as one text."""
    return repr([kept.facts(kinds), kept.summary, kept.facts_on_demand(), kept.key]) + encode_scene(
        kept.scene()
    )


def forbid_making(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("a scene was made again")

    monkeypatch.setattr(reader, "read_shape", fail)


def test_what_is_kept_is_what_was_made_and_is_not_made_again(
    keeper: SceneKeeper, box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = reader.read_shape(box, Z)
    first = describe(keeper.open(box, Z))
    forbid_making(monkeypatch)
    again = keeper.open(box, Z)
    assert describe(again) == first
    assert repr(again.facts(KINDS)) == repr(fact_columns(scene, KINDS))
    assert repr(again.facts_on_demand()) == repr(facts_on_demand(scene))
    more = KINDS | {"dihedral", "tilt"} | ON_DEMAND
    assert repr(again.facts(more)) == repr(fact_columns(scene, more))
    assert keeper.open(box, Z).has_facts(more)


def test_a_scene_file_is_read_itself_and_its_facts_are_kept(
    keeper: SceneKeeper, box: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scene.json"
    path.write_text(encode_scene(reader.read_shape(box, Z)))
    data = path.read_bytes()
    first = describe(keeper.open(path, Z, data)), describe(keeper.open(path, Z))
    other = keeper.open(path, ShapeOptions(up=(1.0, 0.0, 0.0)), data)
    assert describe(other) != first[0]
    assert (describe(keeper.open(path, Z, data)), describe(keeper.open(path, Z))) == first
    forbid_making(monkeypatch)
    assert keeper.open(path, Z).facts(KINDS)
    assert {p.suffix for p in (tmp_path / "kept").iterdir()} == {".facts"}


def test_other_content_options_or_files_beside_are_another_scene(
    keeper: SceneKeeper, tmp_path: Path, box: Path
) -> None:
    found = {describe(keeper.open(box, options)) for options in (Z, ShapeOptions(find_floor=True))}
    write_box(box, 2.0)
    found.add(describe(keeper.open(box, Z)))
    assert len(found) == 3

    for folder, height in (("a", 1.0), ("b", 2.0)):
        write_box(tmp_path / folder / "box.gltf", height)
    document = (tmp_path / "a" / "box.gltf").read_bytes()
    names = [buffer["uri"] for buffer in json.loads(document)["buffers"]]
    first = describe(keeper.open(tmp_path / "a" / "box.gltf", Z))
    assert describe(keeper.open(tmp_path / "a" / "box.gltf", Z)) == first
    for name in names:  # the same text names other numbers
        (tmp_path / "a" / name).write_bytes((tmp_path / "b" / name).read_bytes())
    changed = keeper.open(tmp_path / "a" / "box.gltf", Z)
    assert np.ptp(changed.scene().points, axis=0).max() == pytest.approx(2.0, abs=1e-6)
    assert describe(changed) != first
    (tmp_path / "a" / names[0]).unlink()
    with pytest.raises(InputError, match="missing"):
        keeper.open(tmp_path / "a" / "box.gltf", Z).scene()


DAMAGES: dict[str, Callable[[Path, Path], object]] = {
    "cut": lambda path, _: path.write_bytes(path.read_bytes()[:-9]),
    "empty": lambda path, _: path.write_bytes(b""),
    "garbage": lambda path, _: path.write_bytes(os.urandom(2000)),
    "pickle": lambda path, _: path.write_bytes(b"cos\nabort\n(tR."),
    "of another scene": lambda path, other: path.write_bytes(other.read_bytes()),
    "folder": lambda path, _: (path.unlink(), path.mkdir()),
    "pipe": lambda path, _: (path.unlink(), os.mkfifo(path)),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())
def test_a_damaged_file_is_made_again(
    keeper: SceneKeeper, box: Path, tmp_path: Path, damage: Callable[[Path, Path], object]
) -> None:
    other = write_box(tmp_path / "other.ply", 3.0)
    expected = describe(keeper.open(box, Z))
    own = set((tmp_path / "kept").iterdir())
    describe(keeper.open(other, Z))
    others = {path.suffix: path for path in (tmp_path / "kept").iterdir() if path not in own}
    assert {path.suffix for path in own} == {".shape", ".facts"}
    for path in own:
        damage(path, others[path.suffix])
    assert describe(keeper.open(box, Z)) == expected
    assert not list((tmp_path / "kept").glob("*.part"))


KILLED = """
import os, signal, sys
from pathlib import Path
from tests.shell.test_kept_scenes import KINDS, SceneKeeper, Z

moment, left = sys.argv[1], int(sys.argv[2])
fdopen, replace = os.fdopen, Path.replace

def die():
    global left
    left -= 1
    if not left:
        os.kill(os.getpid(), signal.SIGKILL)

def write(descriptor, mode):
    if mode == "wb" and moment == "within":
        os.write(descriptor, b"facetlog cache")
        die()
        os.ftruncate(descriptor, os.lseek(descriptor, 0, os.SEEK_SET))
    return fdopen(descriptor, mode)

def rename(path, target):
    if moment == "before it is there":
        die()
    return replace(path, target)

os.fdopen, Path.replace = write, rename
SceneKeeper(Path(sys.argv[3])).open(Path(sys.argv[4]), Z).facts(KINDS)
"""


@pytest.mark.parametrize("moment", ["within", "before it is there"])
@pytest.mark.parametrize("which", [1, 2])
def test_what_a_kill_leaves_of_a_file_is_not_read(
    keeper: SceneKeeper, box: Path, tmp_path: Path, moment: str, which: int
) -> None:
    expected = describe(SceneKeeper(tmp_path / "others").open(box, Z))
    kept = tmp_path / "kept"
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, moment, str(which), str(kept), str(box)],
        env=make_importing_environment(),
        check=False,
    )
    assert killed.returncode == -signal.SIGKILL
    assert len(list(kept.glob("*.part"))) == 1
    assert CacheFolder(kept).measure()[0] == which - 1
    assert describe(keeper.open(box, Z)) == expected
    assert describe(keeper.open(box, Z)) == expected


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EROFS, errno.EACCES])
def test_a_folder_that_cannot_be_written_costs_no_scene(
    keeper: SceneKeeper, box: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: int
) -> None:
    def fail(*_: object) -> None:
        raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr(cache_folder, "replace_file", fail)
    first = describe(keeper.open(box, Z))
    assert describe(keeper.open(box, Z)) == first
    assert not list((tmp_path / "kept").iterdir())


def test_what_changes_while_it_is_read_is_no_scene_and_is_not_kept(
    keeper: SceneKeeper, box: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, before = reader.read_shape, box.read_bytes()

    def read_slowly(path: Path, options: ShapeOptions) -> object:
        write_box(box, 2.0)
        scene = read(path, options)
        if restores:
            box.write_bytes(before)
        return scene

    monkeypatch.setattr(reader, "read_shape", read_slowly)
    for restores in (False, True):
        box.write_bytes(before)
        kept = keeper.open(box, Z)
        if restores:  # what was hashed is there again, and is not what was read
            assert kept.scene() is not None
            assert kept.key is None
        else:
            with pytest.raises(InputError, match="changed while it was read"):
                kept.scene()
    assert not list((tmp_path / "kept").iterdir())


def test_clearing_leaves_what_is_not_ours(keeper: SceneKeeper, box: Path, tmp_path: Path) -> None:
    describe(keeper.open(box, Z))
    (tmp_path / "kept" / "notes.txt").touch()
    folder = CacheFolder(tmp_path / "kept")
    count, size = folder.measure()
    assert (count, size > 1000) == (2, True)
    folder.clear()
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["notes.txt"]
