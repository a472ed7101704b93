"""Model files in the knowledge base: compiled, with the files that they ask about."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import RuleSyntaxError
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.rule_source import read_rule_sources
from facetlog.kb.recognize import rule_files
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid

SLAB = """model slab
  "A level board."
  face top
  level: top is level, top is upward  "it lies level"
  thin: height(this) at most 20 % of length(this)  "it is thin"
"""
PARENT = 'use "slab.model"\n'
PLANK = (
    PARENT
    + """model plank is slab
  long: length(this) at least 300 % of width(this)  "it is long"
"""
)
THINGS = (
    PARENT
    + """model couple
  one slab board
  only: count(other) at most 9  "few others"
  any number of slab other where other touches board
"""
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("slab", SLAB), ("plank", PLANK)):
        (tmp_path / f"{name}.model").write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def slab_facts() -> tuple[Fact, ...]:
    return tuple(f.row for f in scene_facts(cuboid(0.8, 0.2, 0.02)))


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as found:
        yield found


def test_a_model_file_is_loaded_like_a_rule_file(
    folder: Path, base: KnowledgeBase, slab_facts: tuple[Fact, ...]
) -> None:
    rules = base.load_rules(folder / "slab.model")
    assert rules.models == ("slab",)
    assert rules.files[0] == folder / "slab.model"
    base.load_scene("s", slab_facts)
    verdict = base.why("s", "slab")
    assert verdict.state is State.HOLDS
    assert [c.label for c in verdict.conditions] == ["level", "thin"]
    assert verdict.conditions[1].reason == "it is thin"


def test_what_a_model_inherits_comes_with_it(
    folder: Path, base: KnowledgeBase, slab_facts: tuple[Fact, ...]
) -> None:
    rules = base.load_rules(folder / "plank.model")
    assert rules.models == ("plank",)
    assert set(rules.files) == {folder / "plank.model", folder / "slab.model"}
    base.load_scene("s", slab_facts)
    assert {c.label for c in base.why("s", "plank").conditions} == {"level", "thin", "long"}


def test_a_faulty_model_file_is_refused_with_all_its_faults(
    folder: Path, base: KnowledgeBase
) -> None:
    path = folder / "slab.model"
    path.write_text(SLAB.replace("level,", "levle,").replace("20 %", "20 deg"), encoding="utf-8")
    with pytest.raises(RuleSyntaxError) as caught:
        base.load_rules(path)
    lines = str(caught.value).splitlines()
    assert [line.split(": ")[0] for line in lines] == [f"{path}:4:17", f"{path}:5:30"]
    assert "slab" not in base.models


def test_a_folder_may_hold_both_kinds_of_files(folder: Path) -> None:
    (folder / "other.pl").write_text("")
    (folder / "notes.txt").write_text("")
    names = [path.name for path in rule_files([folder])]
    assert names == ["other.pl", "plank.model", "slab.model"]


def test_words_that_a_model_uses_come_with_it(
    folder: Path, base: KnowledgeBase, slab_facts: tuple[Fact, ...]
) -> None:
    (folder / "words.pl").write_text(
        ":- module(words, []).\n:- use_module(facetlog(vocabulary)).\n"
        'word(slanted(face), condition, "it stands at a slant").\n'
        "means(slanted(F), between(tilt(F), 20, 70)).\n"
    )
    (folder / "roof.model").write_text(
        'use "words.pl"\nmodel roof\n  face side\n  slant: side is not slanted\n'
    )
    assert "words.pl" not in [path.name for path in rule_files([folder])]
    assert rule_files([folder / "words.pl"]) == ((folder / "words.pl").resolve(),)
    with pytest.raises(RuleSyntaxError, match=r"words\.pl: rules in Prolog are a program"):
        base.load_rules(folder / "roof.model")
    rules = base.load_rules(folder / "roof.model", trusted=True)
    assert set(rules.files) == {folder / "roof.model", folder / "words.pl"}
    base.load_scene("s", slab_facts)
    assert base.why("s", "roof").state is State.HOLDS


def test_files_whose_models_are_asked_about_are_loaded_first(
    folder: Path, base: KnowledgeBase
) -> None:
    (folder / "couple.model").write_text(THINGS, encoding="utf-8")
    path = folder / "couple.model"
    assert [source.path.name for source in read_rule_sources(path)] == [
        "slab.model",
        "couple.model",
    ]
    assert [s.path.name for s in read_rule_sources(path, present=[folder / "slab.model"])] == [
        "couple.model"
    ]
    base.load_rules(path)
    assert {"slab", "couple"} <= base.models.keys()
    base.load_rules(path)  # again: what is there already is not in its way


def test_files_that_ask_about_each_other_are_each_loaded_once(
    folder: Path, base: KnowledgeBase
) -> None:
    (folder / "couple.model").write_text(THINGS, encoding="utf-8")
    (folder / "slab.model").write_text(
        'use "couple.model"\n' + SLAB + "model pile\n  one couple first\n  many: first is couple\n",
        encoding="utf-8",
    )
    base.load_rules(folder / "couple.model")
    assert {"slab", "couple", "pile"} <= base.models.keys()


def test_nothing_stays_of_what_a_refused_file_needed(folder: Path, base: KnowledgeBase) -> None:
    (folder / "couple.model").write_text(THINGS, encoding="utf-8")
    (folder / "first.model").write_text(SLAB.replace("slab", "couple"), encoding="utf-8")
    base.load_rules(folder / "first.model")
    with pytest.raises(RuleSyntaxError, match="already defined"):
        base.load_rules(folder / "couple.model")
    assert "slab" not in base.models
