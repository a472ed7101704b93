"""Built-in models are compiled at first use."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.loading import builtin_rules as rules
from facetlog.kb.loading.builtin_rules import builtin_rules


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Return a cache that is empty, as for a process that begins."""
    monkeypatch.delenv("FACETLOG_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(rules, "_folder", rules._folder.__wrapped__)
    return tmp_path / "facetlog" / "rules"


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


ALL = {f"{name}.pl" for name in BUILTIN_MODELS}


def test_models_are_compiled_into_the_cache_once(fresh: Path) -> None:
    folder = builtin_rules()
    assert folder.parent == fresh
    assert names(folder) == ALL
    made = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert builtin_rules() == folder
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == made


def test_few_versions_are_kept(monkeypatch, fresh: Path) -> None:
    monkeypatch.setattr(rules, "KEPT_S", -1.0)
    for number in range(rules.MOST_KEPT + 3):
        (fresh / str(number)).mkdir(parents=True)
    assert builtin_rules().name in names(fresh)
    assert len(names(fresh)) == rules.MOST_KEPT


def test_a_changed_model_has_another_folder(
    fresh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rules").mkdir()
    model = tmp_path / "rules" / "slab.model"
    folders = set()
    monkeypatch.setattr(rules, "house", lambda name: tmp_path / name)
    monkeypatch.setattr(rules, "BUILTIN_MODELS", ("slab",))
    for height in ("10 cm", "20 cm"):
        model.write_text(f'model slab\n  face top\n\n  low: height(top) at most {height} "low"\n')
        folders.add(builtin_rules())
    assert [names(folder) for folder in folders] == [{"slab.pl"}] * 2


@pytest.mark.parametrize("where", ["off", "a file"])
def test_without_a_cache_they_are_in_a_temporary_folder(
    fresh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    if where == "off":
        monkeypatch.setenv("FACETLOG_CACHE", "off")
    else:
        (tmp_path / "file").write_text("")
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    folder = rules._folder()
    monkeypatch.setattr(rules, "_folder", lambda: folder)
    assert names(builtin_rules()) == ALL
    assert not fresh.exists()


def test_several_processes_may_compile_at_once(fresh: Path) -> None:
    code = "from facetlog.kb.loading.builtin_rules import builtin_rules; print(builtin_rules())"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    started = [
        subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE)
        for _ in range(2)
    ]
    said = {process.communicate()[0].decode().strip() for process in started}
    assert [names(Path(folder)) for folder in said] == [ALL]
