"""A COLMAP model gives the views that transforms.json of the same pictures gives."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.register import has_poses, read_poses
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.pose_folders import same_views
from tests.perception.reading.view_folders import (
    HEIGHT,
    OF_TRANSFORMS,
    WIDTH,
    colmap_rows,
    write_colmap_binary,
    write_colmap_text,
    write_pictures,
    write_tour,
    write_transforms,
)

WRITERS = [write_colmap_text, write_colmap_binary]
Writer = Callable[..., Path]


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(
    ("place", "pictures"),
    [("", "images"), ("", ""), ("model", ""), ("sparse", ""), ("colmap/sparse/0", "images")],
)
def test_a_model_gives_the_views_of_transforms_json(
    tmp_path: Path, write: Writer, place: str, pictures: str
) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted"), unit="cm")
    folder = tmp_path / "tour"
    write_pictures(folder / pictures)
    model = write(folder / place, colmap_rows())
    found = read_views(folder if place != "model" else next(model.glob("images.*")), unit="cm")
    same_views(found.views, wanted.views)
    assert (found.name, found.metric, found.up) == ("tour", True, None)


K = 0.01, 0.02, 0.03, 0.04, 0.05, 0.06
P, PRISM = (7e-3, 8e-3), (1e-3, 2e-3, 3e-3, 4e-3)
NONE, POLYNOMIAL, FISHEYE = Distortion.NONE, Distortion.POLYNOMIAL, Distortion.FISHEYE
# Of each model, in the order of COLMAP's numbers: its parameters after the centre, and what a lens
# then is, its coefficients as OpenCV names them.
MODELS: list[tuple[str, tuple[float, ...], Distortion, dict[str, Any]]] = [
    ("SIMPLE_PINHOLE", (), NONE, {}),
    ("PINHOLE", (), NONE, {}),
    ("SIMPLE_RADIAL", K[:1], POLYNOMIAL, {"radial": (0.01, 0, 0, 0)}),
    ("RADIAL", K[:2], POLYNOMIAL, {"radial": (0.01, 0.02, 0, 0)}),
    ("OPENCV", (*K[:2], *P), POLYNOMIAL, {"radial": (0.01, 0.02, 0, 0), "tangential": P}),
    ("OPENCV_FISHEYE", K[:4], FISHEYE, {"radial": K[:4]}),
    (
        *("FULL_OPENCV", (*K[:2], *P, *K[2:]), POLYNOMIAL),
        {"radial": (*K[:3], 0), "tangential": P, "rational": K[3:]},
    ),
    ("FOV", (0.4,), Distortion.FOV, {"projection": (0.4,)}),
    ("SIMPLE_RADIAL_FISHEYE", (0.1,), FISHEYE, {"radial": (0.1, 0, 0, 0)}),
    ("RADIAL_FISHEYE", K[:2], FISHEYE, {"radial": (0.01, 0.02, 0, 0)}),
    (
        *("THIN_PRISM_FISHEYE", (*K[:2], *P, *K[2:4], 1e-3, 3e-3), FISHEYE),
        {"radial": K[:4], "tangential": P, "prism": (1e-3, 0, 3e-3, 0)},
    ),
    (
        *("RAD_TAN_THIN_PRISM_FISHEYE", (*K, *P[::-1], *PRISM), Distortion.FISHEYE_RADIAL_FIRST),
        {"radial": K, "tangential": P, "prism": PRISM},
    ),
    ("SIMPLE_DIVISION", (0.1,), Distortion.DIVISION, {"projection": (0.1,)}),
    ("DIVISION", (0.1,), Distortion.DIVISION, {"projection": (0.1,)}),
    ("SIMPLE_FISHEYE", (), FISHEYE, {}),
    ("FISHEYE", (), FISHEYE, {}),
    ("EUCM", (0.6, 1.2), Distortion.UNIFIED, {"projection": (0.6, 1.2)}),
]


@pytest.mark.parametrize("number", range(len(MODELS)))
def test_every_camera_model_is_read_in_the_order_of_its_parameters(
    tmp_path: Path, number: int
) -> None:
    name, parameters, distortion, lens = MODELS[number]
    fy = 50 if name.startswith(("SIMPLE", "RADIAL")) else 51
    focal = (50,) if fy == 50 else (50, 51)
    camera_row = name, number, (*focal, 24, 16, *parameters)
    path = write_colmap_text(tmp_path / "text", colmap_rows(), camera_row) / "images.txt"
    other = write_colmap_binary(tmp_path / "binary", colmap_rows(), camera_row) / "images.bin"
    found, same = (
        read_poses(each, PoseOptions()).pictures[0].intrinsics.lens(WIDTH, HEIGHT)
        for each in (path, other)
    )
    assert same == found
    camera = found.camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (50, fy, 23.5, 15.5)
    assert found.distortion is distortion
    none = {"radial": (0,) * 4, "tangential": (0, 0), "rational": (0,) * 3, "prism": (0,) * 4}
    for field, value in ({**none, "projection": ()} | lens).items():
        assert getattr(found, field) == value, field


def test_unknown_camera_models_are_named_with_the_way_out(tmp_path: Path) -> None:
    write_pictures(tmp_path)
    write_colmap_text(tmp_path, colmap_rows(), ("BENT", 99, (50.0, 1.0)))
    with pytest.raises(CalibrationError, match=r"cameras\.txt:2: .*'BENT'.*image_undistorter"):
        read_views(tmp_path)
    write_colmap_binary(tmp_path, colmap_rows(), ("BENT", 99, (50.0, 1.0)))
    with pytest.raises(InputError, match=r"cameras\.bin: camera 7 .* 99.*image_undistorter"):
        read_views(tmp_path)


@pytest.mark.parametrize("name", ["cameras.bin", "images.bin"])
def test_a_binary_file_cut_anywhere_is_refused(tmp_path: Path, name: str) -> None:
    write_pictures(tmp_path)
    whole = (write_colmap_binary(tmp_path, colmap_rows()) / name).read_bytes()
    for length in range(0, len(whole), 7):
        (tmp_path / name).write_bytes(whole[:length])
        with pytest.raises(InputError, match=rf"{name}: .*truncated or damaged; export it again"):
            read_views(tmp_path)


def test_a_missing_picture_is_left_out_and_a_name_may_have_spaces(tmp_path: Path) -> None:
    rows = [*colmap_rows(2), ("my  third one.png", colmap_rows()[2][1])]
    write_pictures(tmp_path / "images")
    write_colmap_text(tmp_path, rows)
    (problem,) = read_views(tmp_path).problems
    assert "my  third one.png" in problem
    (tmp_path / "images" / "2.png").rename(tmp_path / "images" / "my  third one.png")
    assert len(read_views(tmp_path).views) == 3


def test_two_kinds_are_refused_unless_one_was_made_from_the_other(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path / "made")
    write_colmap_text(folder / "colmap" / "sparse" / "0", colmap_rows(2))
    assert read_views(folder).description.startswith("nerfstudio's transforms.json, 3 pictures")
    write_colmap_text(write_tour(tmp_path) / "sparse", colmap_rows(2))
    both = r"sparse/images\.txt \(COLMAP model\) and poses\.csv \(pan-tilt tour\): name the one"
    with pytest.raises(InputError, match=both):
        read_views(tmp_path)
    assert len(read_views(tmp_path / "sparse" / "images.txt").views) == 2


@pytest.mark.parametrize("write", WRITERS)
def test_of_several_models_the_largest_is_read(tmp_path: Path, write: Writer) -> None:
    write_pictures(tmp_path / "images")
    for number, count in ((0, 2), (2, 3), (10, 2)):
        write(tmp_path / "sparse" / str(number), colmap_rows(count))
    found = read_views(tmp_path)
    assert len(found.views) == 3
    assert found.description.startswith("COLMAP model sparse/2, the largest of 3, 3 pictures")
    (named,) = (tmp_path / "sparse" / "10").glob("images.*")
    assert read_views(named).description.startswith("COLMAP model, 2 pictures")
    write(tmp_path / "sparse" / "0", colmap_rows(3))  # of equals the first, as they are counted
    assert read_views(tmp_path).description.startswith("COLMAP model sparse/0, the largest of 3")


@pytest.mark.parametrize("place", [".", "sparse/0"])
def test_a_model_whose_pictures_are_elsewhere_says_where_they_belong(
    tmp_path: Path, place: str
) -> None:
    write_colmap_text(tmp_path / place, colmap_rows())
    with pytest.raises(InputError, match=rf"put the pictures into {tmp_path / 'images'}$"):
        read_views(tmp_path)


@pytest.mark.parametrize(("kept", "gone"), [("images", "cameras"), ("cameras", "images")])
def test_half_a_model_is_named_even_beside_pictures(tmp_path: Path, kept: str, gone: str) -> None:
    write_colmap_binary(tmp_path / "sparse", colmap_rows())
    (tmp_path / "sparse" / f"{gone}.bin").unlink()
    write_pictures(tmp_path)
    says = rf"part of a COLMAP model: sparse/{gone}\.bin is missing beside {kept}\.bin; to go"
    with pytest.raises(InputError, match=says):
        read_views(tmp_path)


def test_a_model_without_pictures_is_a_cloud(tmp_path: Path) -> None:
    write_colmap_text(tmp_path / "sparse", colmap_rows(), OF_TRANSFORMS)
    assert not has_poses(tmp_path)
    write_pictures(tmp_path / "images")
    assert has_poses(tmp_path)
