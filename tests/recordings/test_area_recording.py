"""The recording of an explored area: each view once, with what those of its place show."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.exploring.area_judge import place_seen
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.pipeline import open_models
from facetlog.recordings.area_recording import AreaRecording
from facetlog.recordings.moments import Moment
from facetlog.recordings.recorders import Recordings, record_collection
from tests.mapping.rooms import write_visit
from tests.recordings.test_mcap_recording import messages

ON_THE_WAY, COUNT = 1, 6


class Kept:
    """A recorder that keeps what comes."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []

    def add(self, moment: Moment) -> None:
        self.moments.append(moment)

    def close(self) -> None: ...


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with open_models() as opened:
        yield opened


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("area") / "views"
    write_visit(found, 0.0, count=COUNT, on_the_way=ON_THE_WAY)
    return found


@pytest.fixture(scope="module")
def kept(folder: Path, base: KnowledgeBase) -> Kept:
    found = Kept()
    AreaRecording(folder, base, found).rest()
    return found


def names_of(kept: Kept) -> list[str]:
    return [moment.taken.name for moment in kept.moments]


def test_each_view_shows_what_those_of_its_place_showed_by_then(kept: Kept) -> None:
    assert len(kept.moments) == COUNT
    assert [moment.place for moment in kept.moments] == [0, 1, 1, 1, 1, 1]
    # Of the view on the way nothing is judged, nor of fewer than a face needs.
    assert [moment.scene is not None for moment in kept.moments] == [*[False] * 3, *[True] * 3]
    last = kept.moments[-1].recognition
    assert last is not None
    assert last.best[0].model == "box"
    assert len({verdict.thing for verdict in last.verdicts}) == 1
    parts = [at for moment in kept.moments for at, _ in moment.way]
    assert parts == sorted(set(parts))


def test_what_the_explorer_found_is_recorded_as_it_found_it(
    folder: Path, base: KnowledgeBase, kept: Kept
) -> None:
    names = tuple(names_of(kept)[ON_THE_WAY:-1])
    seen = place_seen(folder, names, base)
    again = Kept()
    recording = AreaRecording(folder, base, again)
    recording.add(names, seen)
    assert names_of(again) == names_of(kept)[:-1]
    assert again.moments[-1].scene is seen.found.scene
    # It is asked once more when it goes on with the place, and at the end.
    recording.add(names, seen)
    recording.rest()
    recording.rest()
    assert names_of(again) == names_of(kept)


def test_a_place_whose_views_make_no_scene_is_recorded_without_one(
    folder: Path, base: KnowledgeBase, kept: Kept
) -> None:
    names = tuple(names_of(kept)[ON_THE_WAY:-2])
    again = Kept()
    AreaRecording(folder, base, again).add(names, None)
    assert names_of(again) == names_of(kept)[:-2]
    assert again.moments[-1].scene is None
    assert again.moments[-1].recognition is None


def test_a_folder_of_an_area_is_recorded_place_by_place(
    folder: Path, base: KnowledgeBase, tmp_path: Path
) -> None:
    path = tmp_path / "area.mcap"
    assert record_collection(folder, Recordings(mcap=path), base) == COUNT
    found = messages(path)
    assert len(found["/camera/image/compressed"]) == COUNT
    *_, (_, verdicts) = found["/facetlog/verdicts"]
    assert any("is a box" in each.text for each in verdicts.markers)
    assert {each.ns for each in verdicts.markers if each.text} == {"place 1 verdicts"}


def test_a_folder_without_a_view_is_refused(base: KnowledgeBase, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no collection"):
        AreaRecording(tmp_path, base, Kept()).rest()
