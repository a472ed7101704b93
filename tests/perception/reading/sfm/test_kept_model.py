"""A model is kept with what it was made from, and used for nothing else."""

from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.image_sources import Shot
from facetlog.perception.reading.sfm import sfm_poses
from facetlog.perception.reading.sfm.outcome import Outcome, Pair, Settings
from facetlog.perception.reading.sfm.sfm_poses import (
    check_keep,
    keep_model,
    load_kept_outcome,
    made_from,
)

OUTCOME = Outcome({"a": 9, "b": 8}, (), (Pair("a", "b", 7),), (("a", "b"),), 0.5)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "images.bin").write_bytes(b"1")
    return folder


def test_what_is_kept_comes_back_for_the_same_key_alone(tmp_path: Path, model: Path) -> None:
    keep = tmp_path / "new" / "out-cameras"
    check_keep(keep)
    keep_model(keep, model, "first", OUTCOME)
    assert load_kept_outcome(keep, "first") == OUTCOME
    assert load_kept_outcome(keep, "second") is None
    check_keep(keep)
    (model / "images.bin").rename(model / "cameras.bin")
    keep_model(keep, model, "second", replace(OUTCOME, error_px=0.7))
    assert sorted(path.name for path in keep.iterdir()) == ["cameras.bin", "facetlog.json"]
    assert load_kept_outcome(keep, "first") is None


def test_what_is_left_of_an_attempt_is_ours_and_not_used(
    tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sfm_poses.shutil, "copyfile", interrupted)
    with pytest.raises(KeyboardInterrupt):
        keep_model(tmp_path / "kept", model, "key", OUTCOME)
    check_keep(tmp_path / "kept")
    assert load_kept_outcome(tmp_path / "kept", "key") is None


@pytest.mark.parametrize("record", ["{", "[]", '{"schema": "facetlog-cameras/0"}'])
def test_a_folder_without_a_record_of_ours_is_refused(record: str, tmp_path: Path) -> None:
    (tmp_path / "facetlog.json").write_text(record)
    with pytest.raises(InputError, match="was not written by facetlog"):
        check_keep(tmp_path)


def test_another_picture_name_or_setting_is_another_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sfm_poses.importlib.metadata, "version", lambda _: "4.2.1")
    one, other = Shot(tmp_path / "a.png"), Shot(tmp_path / "b.png")
    one.path.write_bytes(b"1")
    other.path.write_bytes(b"1")
    keys = {
        made_from((one,), Settings()),
        made_from((other,), Settings()),
        made_from((one, other), Settings()),
        made_from((one,), Settings(seed=1)),
    }
    one.path.write_bytes(b"2")
    keys.add(made_from((one,), Settings()))
    assert len(keys) == 5
