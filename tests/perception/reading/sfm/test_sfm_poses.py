"""Pictures without poses and mat: which way is taken, what is kept, and what is said."""

import re
import sys
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import facetlog
from facetlog.cli import main
from facetlog.errors import EngineError, InputError
from facetlog.perception.reading.read_views import ViewSet, read_views
from facetlog.perception.reading.sfm import sfm_poses
from facetlog.perception.types import Pose
from tests.perception.reading.sfm.newspaper import BOX, CAMERA, around, taken

needs_pycolmap = pytest.mark.skipif(
    find_spec("pycolmap") is None, reason="pycolmap is not installed (extra sfm)"
)


def plain(folder: Path, count: int = 3) -> Path:
    """A folder of pictures of nothing, in noise."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    for k in range(count):
        grey = rng.normal(120.0, 2.0, (120, 160))
        assert cv2.imwrite(str(folder / f"{k}.png"), np.rint(grey).astype(np.uint8))
    return folder


@pytest.fixture
def without_pycolmap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pycolmap", None)


@pytest.fixture
def with_pycolmap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("facetlog.perception.reading.pose_files.register.can_map", lambda: True)


@pytest.mark.usefixtures("without_pycolmap")
def test_without_the_extra_one_line_names_it_and_the_mat(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recognize", str(plain(tmp_path / "photos"))]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "photos: no mat is seen in any of 3 pictures: print one (facetlog mat" in line
    assert line.endswith("or let facetlog find poses by texture: pip install 'facetlog[sfm]'")


@pytest.mark.usefixtures("with_pycolmap")
@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--up", "z"], "up: no axis of a world that structure from motion makes can be known"),
        (["--unit", "m"], 'unit .* a known length as scale does: "height = 74 cm"'),
        (["--square", "17mm"], "no mat is seen in any of 3 pictures: print one"),
    ],
)
def test_what_such_poses_do_not_go_with_is_refused_before_any_work(
    options: list[str], line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recognize", str(plain(tmp_path / "photos")), *options]) == 2
    assert re.search(line, capsys.readouterr().err)


@pytest.mark.usefixtures("with_pycolmap")
@pytest.mark.parametrize(
    ("program", "line"),
    [
        ("import os, sys; print('out of luck', file=sys.stderr); os.abort()", "out of luck: try"),
        ("pass", "ended with code 0: it said nothing: try again with fewer or smaller pictures"),
    ],
)
def test_a_program_that_dies_is_an_error_that_says_so(
    program: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sfm_poses, "PROGRAM", (sys.executable, "-c", program))
    with pytest.raises(EngineError, match=line):
        read_views(plain(tmp_path / "photos"))


@pytest.mark.usefixtures("with_pycolmap")
def test_a_folder_of_someone_else_is_not_overwritten_by_cameras(tmp_path: Path) -> None:
    kept = tmp_path / "out-cameras"
    kept.mkdir()
    (kept / "letters.txt").write_text("dear")
    with pytest.raises(InputError, match=r"out-cameras, where the cameras .* was not written by"):
        read_views(plain(tmp_path / "photos"), keep=kept)
    assert (kept / "letters.txt").read_text() == "dear"


@needs_pycolmap
def test_plain_pictures_have_too_little_texture(tmp_path: Path) -> None:
    steps: list[str] = []
    with pytest.raises(InputError, match="no mat is seen in any of 3 pictures, and what they show"):
        read_views(
            plain(tmp_path / "photos"),
            keep=tmp_path / "kept",
            progress=lambda step, *_: steps.append(step),
        )
    assert list(dict.fromkeys(steps)) == ["find features", "match pictures"]
    assert not (tmp_path / "kept").exists()


def similar(found: ViewSet, poses: tuple[Pose, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rotation of the found world into the true one, and what is left of places (as a share of
    their distance from the middle) and of rotations (degrees)."""
    true = [poses[int(Path(view.name).stem)] for view in found.views]
    here = np.array([view.pose.centre for view in found.views])
    there = np.array([pose.centre for pose in true])
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    turn, _ = Rotation.align_vectors(there, here)
    turned = turn.apply(here)
    scale = (turned * there).sum() / (turned**2).sum()
    off = np.linalg.norm(scale * turned - there, axis=1) / np.linalg.norm(there, axis=1).mean()
    turns = [
        (turn * Rotation.from_matrix(view.pose.rotation)).inv() * Rotation.from_matrix(p.rotation)
        for view, p in zip(found.views, true, strict=True)
    ]
    return turn.as_matrix(), off, np.degrees([each.magnitude() for each in turns])


@needs_pycolmap
@pytest.mark.slow
def test_a_box_on_a_newspaper_is_a_box(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, kept, poses = tmp_path / "photos", tmp_path / "out-cameras", around(12)
    taken(folder, poses)
    found = read_views(folder, keep=kept)
    assert found.problems == ()
    assert found.up is None
    assert not found.metric
    assert found.description.startswith("structure from motion (its points fit to 0.")
    assert found.description.endswith("12 pictures, up unknown, unit unknown")
    world, places, turns = similar(found, poses)
    assert places.max() < 0.01
    assert turns.max() < 1.0  # the middle of a picture is not quite where the lens looks
    assert found.views[0].camera.fx == pytest.approx(CAMERA.fx, rel=0.02)

    monkeypatch.setattr(sfm_poses, "PROGRAM", (sys.executable, "-c", "raise SystemExit(9)"))
    # What is kept needs no look for a mat either.
    monkeypatch.setattr("facetlog.perception.reading.mat.mat_poses.read_mat", None)
    result = facetlog.recognize(folder, cameras=kept, scale="height = 10 cm")
    assert "t1 is a box (" in str(result)
    assert result.scene.metric
    assert result.scene.up is not None
    # In pictures this small the ground shows up to a degree or two, and with it heights.
    assert world[2] @ result.scene.up > np.cos(np.radians(2.5))
    points = np.array([vertex.point for vertex in result.scene.vertices])
    longest = np.linalg.norm(points[:, None] - points, axis=2).max()
    assert longest == pytest.approx(np.linalg.norm(BOX), rel=0.08)
    assert "up (an axis, or none)" in " ".join(result.scene.warnings)

    monkeypatch.undo()
    monkeypatch.setattr(sfm_poses, "PROGRAM", (sys.executable, "-c", "raise SystemExit(9)"))
    taken(folder, poses[:1], first=12)  # other pictures: what is kept is of no use
    with pytest.raises(EngineError, match="ended with code 9"):
        read_views(folder, keep=kept)


@needs_pycolmap
@pytest.mark.slow
def test_pictures_that_do_not_join_the_others_are_left_out_by_name(tmp_path: Path) -> None:
    poses = around(24)
    taken(tmp_path / "two", poses[:5])
    taken(tmp_path / "two", poses[10:14], first=5, paper=1)
    found = read_views(tmp_path / "two")
    assert [view.name for view in found.views] == [f"0{k}.jpg" for k in range(5)]
    (line,) = found.problems
    assert "05.jpg is one of 4 that do not join the 5 that are used" in line
    assert line.endswith("left out, and so are 06.jpg, 07.jpg, 08.jpg")


@needs_pycolmap
@pytest.mark.slow
def test_pictures_from_one_spot_show_no_depth(tmp_path: Path) -> None:
    pose, *_ = around(1)
    turns = Rotation.from_rotvec(np.outer(np.radians([0, 6, 12]), [0, 0, 1])).as_matrix()
    taken(tmp_path / "spot", tuple(Pose(turn @ pose.rotation, pose.centre) for turn in turns))
    with pytest.raises(InputError, match="places that do not lie apart: walk round the thing"):
        read_views(tmp_path / "spot")
