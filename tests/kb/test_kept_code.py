"""Specialised models that are kept: they judge as those that are written anew."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import BriefVerdict
from facetlog.kb.loading import model_code
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build

Opened = Callable[..., BatchJudge]
LOW = """model low
  "A thing that is low."

  face top

  top is level, top is upward
  low: elevation(top) at most {most} cm
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("FACETLOG_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "facetlog" / "scenes"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> Iterator[Opened]:
    """Opens judges that ignore deviations, as no other test has them open, and closes them."""
    judges: list[BatchJudge] = []

    def open_one(*models: Path, trusted: bool = True) -> BatchJudge:
        judges.append(BatchJudge(models, trusted=trusted, crisp=True))
        return judges[-1]

    yield open_one
    for judge in judges:
        judge.close()


def verdicts(judge: BatchJudge, name: str = "table") -> tuple[BriefVerdict, ...]:
    scene = build(name, {})
    return judge.judge([fact.row for fact in (*scene_facts(scene), *facts_on_demand(scene))])


def is_kept(judge: BatchJudge) -> bool:
    """Return whether its models stand in a module that is named by what it holds."""
    code = judge._code
    return code is not None and code.target.startswith("facetlog_code:")


@pytest.mark.slow
def test_kept_code_judges_as_what_was_written(
    folder: Path, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = opened()
    said = {name: verdicts(first, name) for name in ("table", "chair", "cuboid", "stairs")}
    needed, conditions = first.needed, first.conditions()
    assert len(list(folder.iterdir())) == 1
    first.close()
    monkeypatch.setattr(model_code.SceneCache, "save", None)  # nothing is written again
    again = opened()
    assert is_kept(again)
    assert (again.needed, again.conditions()) == (needed, conditions)
    assert {name: verdicts(again, name) for name in said} == said
    assert {name: verdicts(again, name) for name in said} == said  # nothing is remembered


@pytest.mark.parametrize("cut", [10, pytest.param(1000, marks=pytest.mark.slow), -1])
@pytest.mark.slow
def test_a_damaged_file_is_written_anew(folder: Path, opened: Opened, cut: int) -> None:
    first = opened()
    said = verdicts(first)
    first.close()
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[:cut])
    again = opened()
    assert verdicts(again) == said
    assert file.read_bytes() != whole[:cut]


@pytest.mark.slow
def test_another_text_has_code_of_its_own(folder: Path, opened: Opened, tmp_path: Path) -> None:
    path = tmp_path / "low.model"
    states = []
    for most in (40, 90, 40):
        path.write_text(LOW.format(most=most))
        judge = opened(path)
        (low,) = (said for said in verdicts(judge) if said.model == "low")
        states.append(low.state.value)
        judge.close()
    assert states == ["fails", "holds", "fails"]
    assert len(list(folder.iterdir())) >= 2


@pytest.mark.slow
def test_without_a_cache_models_are_written_each_time(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("FACETLOG_CACHE", "off")
    first = opened()
    said = verdicts(first)
    first.close()
    assert verdicts(opened()) == said
    assert not list(tmp_path.iterdir())
