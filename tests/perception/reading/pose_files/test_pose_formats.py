"""Each format of poses gives the views that transforms.json of the same pictures gives."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.register import read_poses
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.pose_folders import (
    openmvg_camera,
    replace_text,
    same_views,
    write_bundler,
    write_kitti,
    write_openmvg,
    write_polycam,
    write_record3d,
    write_tum,
    write_visualsfm,
)
from tests.perception.reading.view_folders import (
    HEIGHT,
    WIDTH,
    colmap_rows,
    transforms,
    write_colmap_text,
    write_pictures,
    write_transforms,
)

Writer = Callable[[Path], Path]
# Camera models that have one focal length, and a centre in the middle of the picture.
ONE_FOCAL = {"fl_x": 50.0, "fl_y": 50.0}
MIDDLE = ONE_FOCAL | {"cx": WIDTH / 2, "cy": HEIGHT / 2}


def second_camera(folder: Path) -> Path:
    return write_kitti(folder, "image_1", -0.25)


def write_colmap(folder: Path) -> Path:
    write_pictures(folder)
    return write_colmap_text(folder, colmap_rows())


def polycam_of_arkit(folder: Path) -> Path:
    return write_polycam(folder, "cameras")


@pytest.mark.parametrize(
    ("write", "camera", "description"),
    [
        (write_tum, {}, "TUM trajectory, 3 pictures, up unknown"),
        (write_kitti, {}, "KITTI sequence, 3 pictures, up unknown"),
        (second_camera, {}, "KITTI sequence, 3 pictures, up unknown"),
        (write_polycam, {}, "Polycam capture, 3 pictures"),
        (polycam_of_arkit, {}, "Polycam capture, 3 pictures"),
        (write_record3d, {}, "Record3D capture, 3 pictures, up unknown"),
        (write_openmvg, ONE_FOCAL, "OpenMVG model, 3 pictures, up unknown, unit unknown"),
        (
            write_bundler,
            MIDDLE | {"k1": 0.01, "k2": -0.002},
            "Bundler model, 3 pictures, up unknown, unit unknown",
        ),
        (write_visualsfm, MIDDLE, "VisualSFM model, 3 pictures, up unknown, unit unknown"),
    ],
)
def test_a_format_gives_the_views_of_transforms_json(
    tmp_path: Path, write: Writer, camera: dict[str, Any], description: str
) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted", transforms() | camera))
    folder = write(tmp_path / "tour")
    found = read_views(folder)
    same_views(found.views, wanted.views)
    assert (found.name, found.description) == ("tour", description)
    if found.up is not None:
        assert found.up.tolist() == [0.0, 1.0, 0.0]
    in_cm = read_views(folder, unit="cm")
    assert in_cm.metric
    assert in_cm.views[2].pose.centre[0] == 0.02


@pytest.mark.parametrize(
    ("write", "line"),
    [
        (write_tum, "('rgb/late.png'): groundtruth.txt has no pose within 0.02 s; left out"),
        (write_bundler, "images/lost.png has no pose: it was not registered; left out"),
        (write_openmvg, "3.png has no pose: it was not registered; left out"),
    ],
)
def test_pictures_without_a_pose_are_named(tmp_path: Path, write: Writer, line: str) -> None:
    (problem,) = read_views(write(tmp_path)).problems
    assert problem.endswith(line)


BUNDLE_END = "50 0.01 -0.002\n1 0 0\n0 1 0\n0 0 1\n-2 0 0\n1 2 3\n9 9 9\n0\n"
CAMERA_2 = "png\t50 0 1 0 0 2"
FAULTS: list[tuple[Writer, str, str, str, str]] = [
    *(
        (write_tum, "groundtruth.txt", old, new, says)
        for old, new, says in (
            ("12.000 2 0 0 2 0 0 0", "12.000 2 0 0 0 0 0 0", r"groundtruth\.txt:4 .* of length 0"),
            ("12.000 2 0 0", "12.000 nan 0 0", r"groundtruth\.txt:4 .*'rgb/2\.png'.* not 7 finite"),
            ("12.000 2 0 0", "noon 2 0 0", r"groundtruth\.txt:4: not TIME TX"),
        )
    ),
    (write_tum, "rgb.txt", "1", "7", r"no pose is within 0\.02 s .* one clock"),
    (write_kitti, "poses.txt", "1 0 0 1.0", "1 0 0 nan", r"poses\.txt:2 \('image_0/1"),
    (write_kitti, "poses.txt", "1 0 0 1.0", "2 0 0 1.0", r"poses\.txt:2 .*scales"),
    (write_kitti, "poses.txt", "1 0 0 1.0 0 -1 0 0 0 0 -1 0\n", "", r"2 poses, .*3 pictures"),
    (write_kitti, "calib.txt", "P0:", "P9:", r"calib\.txt has no P0"),
    (write_kitti, "calib.txt", "P0: 50", "P0: 0", r"calib\.txt:1: fx is 0"),
    (write_kitti, "calib.txt", "0 0 1 0", "0 0 0 0", r"calib\.txt:1: it projects"),
    *(
        (write_bundler, "bundle/bundle.out", old, new, says)
        for old, new, says in (
            (BUNDLE_END, "50 0 0\n", r"bundle\.out ends before camera 4: it is"),
            ("4 1\n", "5 1\n", r"has 5 cameras, .*list\.txt 4 pictures"),
            ("4 1\n", "four\n", "no number of cameras"),
            ("-2 0 0", "-2 nan 0", r"bundle\.out:22: not 3 finite numbers"),
            ("50 0.01", "-50 0.01", r"bundle\.out:3 \('images/0\.png'\): the focal length is -50"),
            ("1 0 0\n0 1 0", "1 0 0\n0 2 0", r"bundle\.out:3 .*the rotation is not one, it scales"),
        )
    ),
    *(
        (write_visualsfm, "model.nvm", old, new, says)
        for old, new, says in (
            ("NVM_V3 ", "NVM_V2 ", r"model\.nvm:1: the first word is not NVM_V3"),
            ("\n3\n", "\nthree\n", r"model\.nvm:9: not a number of cameras or points"),
            ("4 5 6 9 9 9 0\n\n0\n\n# plys\n0\n", "", r"model\.nvm ends after 1 of 2 lines"),
            (CAMERA_2, "png\t50 0 nan 0 0 2", r":12 \('images/2\.png'\): not 10 finite"),
            (CAMERA_2, "png\t0 0 1 0 0 2", r":12 \('images/2\.png'\): the focal length"),
        )
    ),
    *(
        (write_colmap, name, old, new, says)
        for name, old, new, says in (
            ("images.txt", "1 0.0 1.0", "1 one 1.0", r"images\.txt:2: .* is not IMAGE_ID QW"),
            ("images.txt", "1 0.0 1.0", "1 0.0 0.0", r"txt:2 \('0\.png'\): its quat.* of length 0"),
            ("images.txt", "1 0.0 1.0", "1 nan 1.0", r"txt:2 \('0\.png'\): .* not finite"),
            ("images.txt", " 7 0.png", " 7", r"images\.txt:2: .* is not IMAGE_ID QW"),
            ("images.txt", " 7 0.png", " 8 0.png", r"'0\.png'\): there is no camera 8"),
            ("images.txt", "1.5 2.5 -1 3.5", "1.5 2.5 -1", r"images\.txt:2: the line after it"),
            ("cameras.txt", "24.5 16.5", "24.5", r"s\.txt:2: PINHOLE has 3 parameters, not 4"),
            ("cameras.txt", "48 32 50.0", "48 wide 50.0", r"txt:2: .* is not CAMERA_ID MODEL"),
            ("cameras.txt", "50.0 51.0", "-50 51.0", r"cameras\.txt:2: fx is -50"),
            ("cameras.txt", "PINHOLE", "EUCM 48 32 50 51 24 16 1.5 1\n# ", r"txt:2: alpha must be"),
            ("cameras.txt", "PINHOLE", "EUCM 48 32 50 51 24 16 0.5 0\n# ", "beta above 0"),
        )
    ),
    *(
        (write_polycam, "keyframes/corrected_cameras/9.json", old, new, says)
        for old, new, says in (
            ('"t_12": ', '"t": ', r"9\.json: no 't_12': export it again"),
            ('"fx": 50.0', '"fx": -1', r"9\.json: fx is -1"),
            ('"t_00": 1.0', '"t_00": 2.0', r"9\.json: the rotation is not one, it scales"),
        )
    ),
    *(
        (write_openmvg, "sfm_data.json", old, new, says)
        for old, new, says in (
            ('"views"', '"looks"', r"sfm_data\.json: no 'views'"),
            ('"pinhole"', '"spherical"', r"intrinsic 0: .*'spherical', not one of pinhole,"),
            ('"id_intrinsic": 0', '"id_intrinsic": 8', r"view 0 \('0\.png'\): there is no intr"),
            ("[24.0, 16.0]", "[24.0]", r"intrinsic 0: principal_point: not 2 finite numbers"),
            ('"center": [1, 0, 0]', '"center": [1, 0]', r"'1\.png'\): center: not 3 finite"),
            ("[[1, 0, 0]", "[[2, 0, 0]", r"view 0 \('0\.png'\): .*the rotation is not one"),
        )
    ),
]


@pytest.mark.parametrize(("write", "name", "old", "new", "says"), FAULTS)
def test_faults_are_named_with_their_place(
    tmp_path: Path, write: Writer, name: str, old: str, new: str, says: str
) -> None:
    folder = write(tmp_path)
    replace_text(folder / name, old, new)
    with pytest.raises(InputError, match=says):
        read_views(folder)


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"poses": 3}, r'metadata\.json: no list of "poses"'),
        ({"poses": [[0, 0, 0, 0, 0, 0, 0]] * 3}, r"pose 1: .*of length 0"),
        ({"poses": [[0, 0, 0, 1, 0, 0, 0], [1]]}, r"pose 2: not 7 finite numbers"),
        ({"K": [1, 2]}, r"pose 1: K: not 9 finite numbers"),
        ({"perFrameIntrinsicCoeffs": [[1, 1, 0, 0]]}, r"pose 2: its intrinsics: not 4 finite"),
    ],
)
def test_faults_of_metadata_are_named(tmp_path: Path, document: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_record3d(tmp_path, document))


@pytest.mark.parametrize(
    ("write", "gone", "says"),
    [
        (write_tum, "rgb.txt", r"rgb\.txt is missing beside groundtruth\.txt"),
        (write_tum, "groundtruth.txt", r"groundtruth\.txt is missing beside rgb\.txt"),
        (write_tum, "camera.toml", r'camera\.toml is missing: .* as unit = "m"'),
        (write_kitti, "poses.txt", r"poses\.txt is missing beside calib\.txt"),
        (write_kitti, "calib.txt", r"calib\.txt is missing beside poses\.txt"),
        (write_bundler, "list.txt", r"bundle\.out has no list\.txt beside or above it"),
    ],
)
def test_half_a_recording_is_named(tmp_path: Path, write: Writer, gone: str, says: str) -> None:
    (write(tmp_path) / gone).unlink()
    with pytest.raises(InputError, match=says):
        read_views(tmp_path)


def test_forms_that_are_not_read_are_named_with_the_way_out(tmp_path: Path) -> None:
    (write_pictures(tmp_path / "a") / "sfm_data.bin").write_bytes(b"")
    with pytest.raises(InputError, match=r"write it by openMVG_main_ConvertSfM_DataFormat"):
        read_views(tmp_path / "a")
    (tmp_path / "b").mkdir()
    path = tmp_path / "b" / "box.r3d"
    path.write_bytes(b"PK")
    for given in (path, tmp_path / "b"):
        with pytest.raises(InputError, match=r"unzip box\.r3d -d box"):
            read_views(given)
    with pytest.raises(InputError, match="has no folder image_0 of pictures"):
        read_views(write_kitti(tmp_path / "c", "image_9"))
    (write_pictures(write_visualsfm(tmp_path / "d")) / "other.nvm").write_text("NVM_V3\n")
    with pytest.raises(InputError, match=r"name the one to use of \w+\.nvm and \w+\.nvm; to go"):
        read_views(tmp_path / "d")


@pytest.mark.parametrize("given", ["sequences/00", "poses/00.txt"])
def test_a_kitti_sequence_is_read_as_the_benchmark_unpacks_it(tmp_path: Path, given: str) -> None:
    sequence = write_kitti(tmp_path / "sequences" / "00")
    (tmp_path / "poses").mkdir()
    (sequence / "poses.txt").rename(tmp_path / "poses" / "00.txt")
    found = read_views(tmp_path / given)
    same_views(found.views, read_views(write_kitti(tmp_path / "tour")).views)


def test_corrected_cameras_of_polycam_go_first_and_may_have_no_size(tmp_path: Path) -> None:
    write_polycam(write_polycam(tmp_path, "cameras"), "corrected_cameras")
    wanted = read_views(tmp_path)
    assert wanted.views[0].name.startswith("corrected_images/8")
    for path in (tmp_path / "keyframes" / "corrected_cameras").iterdir():
        fields = json.loads(path.read_text())
        del fields["width"], fields["height"]
        path.write_text(json.dumps(fields))
    same_views(read_views(tmp_path).views, wanted.views)


def test_record3d_metadata_may_have_no_suffix_and_intrinsics_of_each_picture(
    tmp_path: Path,
) -> None:
    each = [[60.0 + k, 61.0, 20.5, 10.5] for k in range(3)]
    write_record3d(tmp_path, {"perFrameIntrinsicCoeffs": each})
    path = (tmp_path / "metadata.json").rename(tmp_path / "metadata")
    last = read_poses(path, PoseOptions()).pictures[2].intrinsics
    assert (last.focal, last.centre) == ((62.0, 61.0), (20.0, 10.0))
    assert len(read_views(tmp_path).views) == 3


@pytest.mark.parametrize(
    ("kind", "more", "distortion", "radial", "tangential"),
    [
        ("pinhole_radial_k1", {"disto_k1": [0.1]}, "polynomial", (0.1, 0, 0, 0), (0, 0)),
        ("pinhole_radial_k3", {"disto_k3": [1, 2, 3]}, "polynomial", (1, 2, 3, 0), (0, 0)),
        ("pinhole_brown_t2", {"disto_t2": [1, 2, 3, 4, 5]}, "polynomial", (1, 2, 3, 0), (4, 5)),
        ("fisheye", {"fisheye": [1, 2, 3, 4]}, "fisheye", (1, 2, 3, 4), (0, 0)),
    ],
)
def test_openmvg_cameras_are_known_by_name_and_then_by_number(
    tmp_path: Path, kind: str, more: dict[str, Any], distortion: str, radial: Any, tangential: Any
) -> None:
    same = openmvg_camera(0, 2, None, more)
    data = same["value"]["ptr_wrapper"]["data"]  # some versions put common fields a level down
    data["value0"] = {key: data.pop(key) for key in ("focal_length", "principal_point")}
    cameras = openmvg_camera(5, 1, "pinhole"), openmvg_camera(7, 2, kind, more), same
    path = write_openmvg(tmp_path, *cameras) / "sfm_data.json"
    found = read_poses(path, PoseOptions()).pictures[0].intrinsics
    assert found.distortion is Distortion(distortion)
    assert (found.radial, found.tangential) == (radial, tangential)
    assert found.focal == (50.0, 50.0)


def test_visualsfm_lenses_and_names_with_spaces(tmp_path: Path) -> None:
    path = write_visualsfm(tmp_path) / "model.nvm"
    replace_text(path, "NVM_V3 ", "NVM_V3 FixedK 60 25 61 17")
    replace_text(path, "2 0 0 0 0", "2 0 0 -0.05 0")
    replace_text(path, "images/2.png", 'images\\my"third.png')
    *_, last = read_poses(path, PoseOptions()).pictures
    lens = last.intrinsics.lens(WIDTH, HEIGHT)
    np.testing.assert_array_equal(lens.camera.matrix, [[60, 0, 24.5], [0, 61, 16.5], [0, 0, 1]])
    assert (lens.distortion, lens.projection) == (Distortion.INVERSE, (-0.05,))
    assert last.path == tmp_path / "images" / "my third.png"
