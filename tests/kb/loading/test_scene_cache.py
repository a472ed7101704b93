"""Compiled scenes: the same facts from the cache as without it, whatever happened to the files."""

import logging
import os
import resource
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import facetlog
from facetlog.cache_folder import CacheFolder, get_default_folder
from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.scene_cache import (
    LOADING_CODE,
    SceneCache,
    _encode_content,
    compute_schema_hash,
)
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.facts.fact_schema import FACT_SCHEMA
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid

BLOCK: tuple[Fact, ...] = tuple(f.row for f in scene_facts(cuboid()))
ODD: tuple[Fact, ...] = (
    ("scene", "it's \x00 \\ \n Ωμέγα 🜁"),
    ("view", "view1", ""),
    ("view", "[]", "{}"),
    ("corner", "f1", 2**200, "v1"),
    ("corner", "f1", -(2**63), "v1"),
    ("corner", "f1", -(2**63), "v1"),
    ("area", "f1", -0.0, 5e-324),
    ("area", "f1", 1.7976931348623157e308, 1.0),
)


class Prolog:
    """Scenes of the process's Prolog, and what they hold."""

    def __init__(self) -> None:
        self.base = KnowledgeBase()
        self.numbers = count()
        self.identity = str(self.ask("cache_identity", ""))

    def ask(self, operation: str, text: str) -> Term:
        return self.base.send(operation, text)

    @contextmanager
    def scene(self, facts: tuple[Fact, ...] = ()) -> Iterator[str]:
        name = f"scene {next(self.numbers)}"
        yield self.base.load_scene(name, facts).module
        self.base.drop_scene(name)

    def facts(self, module: str) -> list[Struct]:
        """Return all facts of a scene, grouped by functor, in their order."""
        (scene,) = (name for name, s in self.base.scenes.items() if s.module == module)
        found = []
        for kind in FACT_SCHEMA:
            names = [f"X{i}" for i in range(kind.arity)]
            rows = self.base.query(f"{kind.functor}({', '.join(names)})", scenes=[scene])
            found.extend(Struct(kind.functor, row) for row in rows)
        return found


@pytest.fixture(scope="module")
def prolog() -> Prolog:
    return Prolog()


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SceneCache:
    monkeypatch.delenv("FACETLOG_CACHE", raising=False)
    return SceneCache(tmp_path / "scenes")


@pytest.fixture
def saved(prolog: Prolog, cache: SceneCache) -> Path:
    """Return the file of the block's scene."""
    path = cache.path("block", prolog.identity)
    assert path is not None
    with prolog.scene(BLOCK) as module:
        assert cache.save(path, module, prolog.ask)
    return path


def loads(prolog: Prolog, cache: SceneCache, path: Path) -> list[Struct] | None:
    """Return facts that the cache puts into a fresh scene, which stays empty if the cache has
    nothing."""
    with prolog.scene() as module:
        count = cache.load(path, module, prolog.ask)
        facts = prolog.facts(module)
        assert len(facts) == (count or 0)
        return None if count is None else facts


def wanted(prolog: Prolog, facts: tuple[Fact, ...]) -> list[Struct]:
    with prolog.scene(facts) as module:
        return prolog.facts(module)


@pytest.mark.parametrize("facts", [BLOCK, ODD, ()], ids=["block", "odd", "empty"])
def test_a_saved_scene_holds_the_same_facts_in_the_same_order(
    prolog: Prolog, cache: SceneCache, facts: tuple[Fact, ...]
) -> None:
    path = cache.path("key", prolog.identity)
    assert path is not None
    assert loads(prolog, cache, path) is None
    with prolog.scene(facts) as module:
        before = prolog.facts(module)
        assert cache.save(path, module, prolog.ask)
        assert prolog.facts(module) == before
    found = loads(prolog, cache, path)
    assert repr(found) == repr(before)  # repr tells -0.0 from 0.0
    assert len(before) == len(facts)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
@pytest.mark.slow
def test_a_flipped_byte_anywhere_is_noticed(
    prolog: Prolog, cache: SceneCache, saved: Path, data: st.DataObject
) -> None:
    whole = saved.read_bytes()
    damaged = bytearray(whole)
    # the head more often than its share: it is where a mistake could be believed
    places = st.integers(0, len(whole) - 1) | st.integers(0, 200)
    for at in data.draw(st.lists(places, min_size=1, max_size=4, unique=True)):
        damaged[at] ^= data.draw(st.integers(1, 255))
    saved.write_bytes(damaged)
    assert loads(prolog, cache, saved) is None
    saved.write_bytes(whole)
    assert loads(prolog, cache, saved) is not None


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.0, 1.0, exclude_max=True), extra=st.binary(max_size=40))
def test_a_cut_or_lengthened_file_is_noticed(
    prolog: Prolog, cache: SceneCache, saved: Path, share: float, extra: bytes
) -> None:
    whole = saved.read_bytes()
    saved.write_bytes(whole[: int(share * len(whole))] + extra)
    assert loads(prolog, cache, saved) is None
    saved.write_bytes(whole + extra + b"\0")
    assert loads(prolog, cache, saved) is None
    saved.write_bytes(whole)


@pytest.mark.parametrize(
    "content",
    [b"", b"\0" * 5000, b"#!/bin/sh\nexit 1\n", b"SWI-Prolog .qlf file\n\0", None],
    ids=["empty", "zeros", "script", "quick load file", "older form"],
)
def test_a_foreign_file_is_not_loaded_and_is_replaced(
    prolog: Prolog, cache: SceneCache, saved: Path, content: bytes | None
) -> None:
    older = saved.read_bytes().replace(b"facetlog cache 1", b"facetlog cache 0", 1)
    saved.write_bytes(older if content is None else content)
    assert loads(prolog, cache, saved) is None
    with prolog.scene(BLOCK) as module:
        assert cache.save(saved, module, prolog.ask)
    assert loads(prolog, cache, saved) == wanted(prolog, BLOCK)


def test_a_file_under_the_name_of_another_is_not_loaded(
    prolog: Prolog, cache: SceneCache, saved: Path
) -> None:
    other = cache.path("another scene", prolog.identity)
    assert other is not None
    saved.rename(other)
    assert loads(prolog, cache, other) is None


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o1777])
def test_a_folder_that_others_may_write_to_is_refused_with_one_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, prolog: Prolog, mode: int
) -> None:
    folder = tmp_path / "open"
    folder.mkdir()
    folder.chmod(mode)
    with caplog.at_level(logging.WARNING):
        cache = SceneCache(folder)
        assert cache.path("key", prolog.identity) is None
        assert cache.load(None, "m", prolog.ask) is None
        assert not cache.save(None, "m", prolog.ask)
    assert [r.getMessage() for r in caplog.records] == [
        f"scenes are not cached: {folder} can be written by other users (chmod go-w would do)"
    ]


def test_a_file_of_another_user_or_behind_a_link_or_pipe_is_not_read(
    prolog: Prolog, cache: SceneCache, saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    me = os.geteuid()
    with monkeypatch.context() as patch:
        patch.setattr(os, "geteuid", lambda: me + 1)
        assert loads(prolog, cache, saved) is None
    elsewhere = saved.with_suffix(".moved")
    saved.rename(elsewhere)
    saved.symlink_to(elsewhere)
    assert loads(prolog, cache, saved) is None
    saved.unlink()
    os.mkfifo(saved)
    assert loads(prolog, cache, saved) is None
    saved.unlink()
    saved.mkdir()
    assert loads(prolog, cache, saved) is None
    with prolog.scene(BLOCK) as module:
        assert not cache.save(saved, module, prolog.ask)


def test_the_default_folder_follows_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert get_default_folder() == tmp_path / "xdg" / "facetlog" / "scenes"
    for relative in ("", "somewhere"):
        monkeypatch.setenv("XDG_CACHE_HOME", relative)
        assert get_default_folder() == tmp_path / ".cache" / "facetlog" / "scenes"


def test_the_environment_turns_the_cache_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FACETLOG_CACHE", "off")
    assert SceneCache(tmp_path / "scenes").path("key", "9.0.4") is None
    assert not (tmp_path / "scenes").exists()


def test_a_disk_without_room_is_no_error(prolog: Prolog, cache: SceneCache, saved: Path) -> None:
    whole = saved.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with prolog.scene(BLOCK) as module:
        for room in (0, 1000, len(whole) - 10):
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
            try:
                assert not cache.save(saved, module, prolog.ask)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, before)
            assert saved.read_bytes() == whole
            assert list(saved.parent.iterdir()) == [saved]
    assert loads(prolog, cache, saved) == wanted(prolog, BLOCK)


def test_what_was_used_longest_ago_goes_first(
    prolog: Prolog, cache: SceneCache, saved: Path
) -> None:
    small = SceneCache(saved.parent, most_bytes=3 * saved.stat().st_size + 100)
    paths = [path for key in "abcd" if (path := small.path(key, prolog.identity)) is not None]
    saved.unlink()
    with prolog.scene(BLOCK) as module:
        for age, path in zip((30, 20, 10), paths, strict=False):
            assert small.save(path, module, prolog.ask)
            os.utime(path, (time.time() - age,) * 2)
        assert loads(prolog, small, paths[0]) is not None
        assert small.save(paths[3], module, prolog.ask)
    assert [path.exists() for path in paths] == [True, False, True, True]


TWO_AT_ONCE = """
import sys
from pathlib import Path
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.scene_cache import SceneCache
base, cache = KnowledgeBase(), SceneCache(Path(sys.argv[1]))
path = cache.path("shared", str(base.send("cache_identity", "")))
facts = [("corner", "f1", i, "v1") for i in range(2000)]
for _ in range(25):
    assert cache.save(path, base.load_scene("s", facts).module, base.send)
    assert cache.load(path, base.load_scene("s", ()).module, base.send) == len(facts)
"""


def test_two_processes_write_and_read_one_file_at_once(tmp_path: Path) -> None:
    root = str(Path(facetlog.__file__).parents[1])
    both = [
        subprocess.Popen(
            [sys.executable, "-c", TWO_AT_ONCE, str(tmp_path / "scenes")],
            env={**os.environ, "PYTHONPATH": root, "FACETLOG_CACHE": ""},
            stderr=subprocess.PIPE,
        )
        for _ in range(2)
    ]
    for process in both:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors.decode()
    assert len(list((tmp_path / "scenes").iterdir())) == 1


def test_content_prolog_and_schema_each_have_a_file_of_their_own(cache: SceneCache) -> None:
    paths = {
        cache.path(content, identity, schema)
        for content in ("a", "b", "a\x00", '"a", "b"')
        for identity in ("9.0.4", "9.2.9")
        for schema in (None, "another")
    }
    assert len(paths) == 16
    assert cache.path("a", "9.0.4", compute_schema_hash()) == cache.path("a", "9.0.4")


def test_a_file_with_other_facts_than_it_says_leaves_the_scene_empty(
    prolog: Prolog, cache: SceneCache, saved: Path, tmp_path: Path
) -> None:
    with prolog.scene(BLOCK) as module:
        file = tmp_path / "facts.qlf"
        save = Struct("save", (Atom(module), Atom(str(file))))
        assert prolog.ask("save_scene", format_prolog_term(save)) == len(BLOCK)
        content = _encode_content(saved, module, file.read_bytes(), len(BLOCK) + 1)
    assert content is not None
    assert CacheFolder(saved.parent).write(saved, content)
    assert loads(prolog, cache, saved) is None


def test_the_folder_is_private(cache: SceneCache, saved: Path) -> None:
    assert stat.S_IMODE(saved.parent.stat().st_mode) == 0o700
    assert stat.S_IMODE(saved.stat().st_mode) == 0o600


def test_a_folder_of_another_user_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    me = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: me + 1)
    assert SceneCache(tmp_path).folder is None
    assert "belongs to another user" in caplog.text


def test_only_old_half_written_files_are_deleted(
    prolog: Prolog, cache: SceneCache, saved: Path
) -> None:
    old, young = saved.with_name("old.part"), saved.with_name("young.part")
    other = saved.with_name("notes.txt")
    for path in (old, young, other):
        path.write_text("half")
    os.utime(old, (time.time() - 7200,) * 2)
    os.utime(other, (time.time() - 7200,) * 2)
    with prolog.scene(BLOCK) as module:
        assert SceneCache(saved.parent).save(saved, module, prolog.ask)
    assert {p.name for p in saved.parent.iterdir()} == {saved.name, "young.part", "notes.txt"}


def test_all_code_that_makes_facts_changes_the_name_of_kept_scenes() -> None:
    for pattern in LOADING_CODE:
        assert list(house("kb").glob(pattern)), pattern
