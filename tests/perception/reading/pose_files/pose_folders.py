"""Folders of poses of each format, with the pictures and cameras of `transforms`."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from facetlog.perception.types import View
from tests.perception.reading.view_folders import CAMERA, HEIGHT, WIDTH, write_pictures


def same_views(found: tuple[View, ...], wanted: tuple[View, ...]) -> None:
    """Fail unless poses, cameras and pixels are the same."""
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose(one.pose.rotation, other.pose.rotation, atol=1e-12)
        np.testing.assert_allclose(one.pose.centre, other.pose.centre, atol=1e-12)
        assert one.camera == other.camera
        np.testing.assert_array_equal(one.image, other.image)


def replace_text(path: Path, old: str, new: str) -> None:
    """Replace a text that the file has."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def write_tum(folder: Path) -> Path:
    write_pictures(folder / "rgb")
    (folder / "groundtruth.txt").write_text(
        "# time tx ty tz qx qy qz qw\n"
        "5.000 9 9 9 0 0 0 1\n"
        "10.010 0 0 0 1 0 0 0\n"
        "12.000 2 0 0 2 0 0 0\n"
        "10.985 1 0 0 1 0 0 0\n"
        "11.050 7 7 7 0 0 0 1\n"
    )
    (folder / "rgb.txt").write_text(
        "# time picture\n10.0 rgb/0.png\n11.0 rgb/1.png\n12.0 rgb/2.png\n20.0 rgb/late.png\n"
    )
    camera = CAMERA.replace('unit = "in"\n', "")
    camera = camera.replace("cx = 23.5\ncy = 15.5", "cx = 24\ncy = 16")  # as of `transforms`
    (folder / "camera.toml").write_text(camera)
    return folder


# The second camera of the rig is 0.25 to the right of the first.
CALIBRATION = (
    "P0: 50 0 24 0 0 51 16 0 0 0 1 0\n"
    "P1: 50 0 24 -12.5 0 51 16 0 0 0 1 0\n"
    "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
)


def write_kitti(folder: Path, pictures: str = "image_0", start: float = 0.0) -> Path:
    write_pictures(folder / pictures)
    rows = (f"1 0 0 {i + start} 0 -1 0 0 0 0 -1 0\n" for i in range(3))
    (folder / "poses.txt").write_text("".join(rows))
    (folder / "calib.txt").write_text(CALIBRATION)
    return folder


def write_bundler(folder: Path) -> Path:
    """Cameras that look along -z with y up; one of four was not registered."""
    write_pictures(folder / "images")
    (folder / "bundle").mkdir(exist_ok=True)
    first, *rest = (f"50 0.01 -0.002\n1 0 0\n0 1 0\n0 0 1\n{-x} 0 0\n" for x in range(3))
    lost = "0 0 0\n" * 5
    text = f"# Bundle file v0.3\n4 1\n{first}{lost}{''.join(rest)}1 2 3\n9 9 9\n0\n"
    (folder / "bundle" / "bundle.out").write_text(text)
    names = "images/0.png 0 50\nimages/lost.png\nimages/1.png\nimages/2.png\n"
    (folder / "list.txt").write_text(names)
    return folder


def write_visualsfm(folder: Path) -> Path:
    """Two models, of which the second one has all pictures."""
    write_pictures(folder / "images")
    rows = [f"images/{i}.png\t50 0 1 0 0 {i} 0 0 0 0\n" for i in range(3)]
    small = f"2\n{''.join(rows[:2])}1\n1 2 3 9 9 9 0\n"
    points = "2\n1 2 3 9 9 9 1 0 0 1 1\n4 5 6 9 9 9 0\n"
    text = f"NVM_V3 \n\n{small}\n3\n{''.join(rows)}\n{points}\n0\n\n# plys\n0\n"
    (folder / "model.nvm").write_text(text)
    return folder


def write_polycam(folder: Path, cameras: str = "corrected_cameras") -> Path:
    """Write keyframes whose names are times; of some length, so that 10 comes after 9."""
    inside = folder / "keyframes"
    pictures = write_pictures(inside / cameras.replace("cameras", "images"))
    (inside / cameras).mkdir(parents=True)
    for k in range(3):
        matrix = np.eye(4)[:3]
        matrix[0, 3] = k
        entries = {
            f"t_{row}{column}": matrix[row, column] for row in range(3) for column in range(4)
        }
        camera = {"fx": 50.0, "fy": 51.0, "cx": 24.5, "cy": 16.5, "width": WIDTH, "height": HEIGHT}
        fields = {**camera, "blur_score": 1.0, **entries}
        (inside / cameras / f"{8 + k}.json").write_text(json.dumps(fields))
        (pictures / f"{k}.png").rename(pictures / f"{8 + k}.png")
    return folder


def write_record3d(folder: Path, document: dict[str, Any] | None = None) -> Path:
    write_pictures(folder / "rgbd")
    columns = [50.0, 0.0, 0.0, 0.0, 51.0, 0.0, 24.5, 16.5, 1.0]
    poses = [[0.0, 0.0, 0.0, 1.0, k, 0.0, 0.0] for k in range(3)]
    whole = {"w": WIDTH, "h": HEIGHT, "fps": 60, "K": columns, "poses": poses}
    (folder / "metadata.json").write_text(json.dumps(whole | (document or {})))
    return folder


NEW_OBJECT = 1 << 31
UNDEFINED = (1 << 32) - 1


def openmvg_view(number: int, pose: int) -> dict[str, Any]:
    data = {"local_path": "", "filename": f"{number}.png", "width": WIDTH, "height": HEIGHT}
    data |= {"id_view": number, "id_intrinsic": 0, "id_pose": pose}
    wrapper = {"id": NEW_OBJECT + number + 1, "data": data}
    return {"key": number, "value": {"polymorphic_id": 1 << 30, "ptr_wrapper": wrapper}}


def openmvg_camera(
    key: int, number: int, name: str | None, more: dict[str, Any] | None = None
) -> dict[str, Any]:
    """A camera of a kind by its number, with the kind's name where it is the first of it."""
    kind: dict[str, Any] = {"polymorphic_id": number}
    if name is not None:
        kind = {"polymorphic_id": NEW_OBJECT + number, "polymorphic_name": name}
    data = {"width": WIDTH, "height": HEIGHT, "focal_length": 50.0, "principal_point": [24.0, 16.0]}
    wrapper = {"id": NEW_OBJECT + 9, "data": data | (more or {})}
    return {"key": key, "value": {**kind, "ptr_wrapper": wrapper}}


def write_openmvg(folder: Path, *cameras: dict[str, Any]) -> Path:
    """Write pictures, and the file in a folder beside them; a fourth view has no pose."""
    write_pictures(folder / "images")
    (folder / "reconstruction").mkdir(exist_ok=True)
    turn = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
    document = {
        "sfm_data_version": "0.3",
        "root_path": "/home/somebody/pictures",
        "views": [*(openmvg_view(k, k + 4) for k in range(3)), openmvg_view(3, UNDEFINED)],
        "intrinsics": cameras or [openmvg_camera(0, 1, "pinhole")],
        "extrinsics": [
            {"key": k + 4, "value": {"rotation": turn, "center": [k, 0, 0]}} for k in range(3)
        ],
    }
    (folder / "reconstruction" / "sfm_data.json").write_text(json.dumps(document))
    return folder / "reconstruction"
