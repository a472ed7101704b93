"""A changing model on many scenes: the verdicts of a batch, with what each condition says."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import facetlog
from facetlog.errors import QueryError, RuleSyntaxError
from facetlog.kb.explaining.proof import State
from facetlog.library.gallery import Gallery
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.scene_file import write_scene

NAMES = ("table", "stool", "cuboid", "shelf")
LOW = """model low
  "A level top that is not high."

  face top where top is level, top is upward

  low: elevation(top) at most {most} cm
"""
SOLID = """model solid
  "A thing with a solid part."

  piece body

  long: length(body) at least 1 cm
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gallery")
    for name in NAMES:
        write_scene(build(name, {}), folder / f"{name}.json")
    (folder / "broken.json").write_text("{")
    return folder


@pytest.fixture(scope="module")
def gallery(folder: Path) -> Iterator[Gallery]:
    with Gallery(folder) as gallery:
        yield gallery


def states(gallery: Gallery, text: str) -> dict[str, State]:
    return {Path(v.path).stem: v.state for v in gallery.judge(text).verdicts}


def test_verdicts_are_those_of_classify(gallery: Gallery, folder: Path, tmp_path: Path) -> None:
    for most in (50, 80):
        path = tmp_path / "low.model"
        path.write_text(LOW.format(most=most))
        frame = facetlog.classify(folder, models=path, workers=1)
        rows = {
            Path(row.path).stem: next(v for v in row.verdicts if v["model"] == "low")
            for row in frame.itertuples()
            if not isinstance(row.error, str)
        }
        found = gallery.judge(LOW.format(most=most)).verdicts
        assert len(found) == len(rows) == len(NAMES)
        for verdict in found:
            row = rows[Path(verdict.path).stem]
            assert verdict.state.value == row["state"]
            assert verdict.degree == pytest.approx(row["degree"], abs=1e-12)
            assert [(p["role"], tuple(p["names"])) for p in row["parts"]] == list(verdict.parts)


def test_conditions_have_values_and_limits(gallery: Gallery) -> None:
    judged = gallery.judge(LOW.format(most=80))
    low = next(i for i, each in enumerate(judged.conditions) if each.label == "low")
    assert judged.conditions[low].text == "elevation(top) at most 80 cm"
    assert judged.conditions[low].compared == (("elevation(top)", "at_most(metres(0.8))"),)
    table = next(v for v in judged.verdicts if Path(v.path).stem == "table")
    (value,) = table.conditions[low].values
    assert value is not None
    assert value.value == pytest.approx(0.74, abs=0.02)
    assert table.conditions[low].state is State.HOLDS


def test_a_text_that_asks_for_other_facts_gets_them(gallery: Gallery) -> None:
    assert states(gallery, LOW.format(most=50))["table"] is State.FAILS
    assert set(states(gallery, SOLID)) == set(NAMES)
    assert states(gallery, LOW.format(most=80))["table"] is State.HOLDS


def test_faults_leave_the_gallery_as_it_was(gallery: Gallery) -> None:
    before = gallery.judge(LOW.format(most=80))
    with pytest.raises(RuleSyntaxError, match=r"^text:1:"):
        gallery.judge("modell x")
    assert gallery.judge(LOW.format(most=80)) == before
    (error,) = before.errors.items()
    assert Path(error[0]).name == "broken.json"


def test_the_nearest_miss_of_what_is_refused_has_reasons(gallery: Gallery) -> None:
    judged = gallery.judge(LOW.format(most=1))
    table = next(v for v in judged.verdicts if Path(v.path).stem == "table")
    assert (table.state, table.conditions) == (State.FAILS, ())
    verdict = gallery.why(table.path, table.thing)
    assert verdict.state is State.FAILS
    assert verdict.parts
    with pytest.raises(QueryError):
        gallery.why(table.path, "t9")
