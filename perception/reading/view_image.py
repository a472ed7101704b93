"""A picture with its lens and pose as a view: undistorted, and reduced where it is large.

Some hundred thousand pixels are enough to find edges and judge faces: twelve megapixels of two
hundred views would fill the memory, and take minutes. Corners are measured in the pictures as
stored, one at a time (detection/line_front_end/side_fit.py).
"""

from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.errors import InputError
from facetlog.perception.reading.lens import Lens
from facetlog.perception.reading.picture_file import (
    LEAST_SIDE_PX,
    read_picture,
    stored_size,
    turned,
)
from facetlog.perception.reading.pose_files.poses_file import PosedPicture
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.types import Image, StoredPicture, View

KEPT_DIAGONAL_PX = 1000.0
"""Larger pictures are reduced to it, as 800 x 600: a bound of cost alone. 12 bytes a pixel are kept
(detection/edge_maps.py and others), so that 200 views fill 1.2 GB."""


class ViewLoader:
    """Loader of the pictures of poses files as views; the set-up of each lens is used again."""

    def __init__(self) -> None:
        self._videos = VideoFrames()
        self._lenses: dict[Lens, Lens] = {}

    def load(self, picture: PosedPicture) -> View | LeftOut:
        """Return the view of a picture, or why it cannot be read or is not of its camera's size.

        CalibrationError if no lens can be of its camera.
        """
        intrinsics = picture.intrinsics
        try:
            # Before it is decoded, which may fill the memory.
            fault = _check_stored_size(picture)
            image = None if fault else self._read(picture)
        except InputError as exc:
            return LeftOut(picture.name, str(exc), str(picture.frame or picture.path))
        if image is not None:
            height, width = image.shape
            fault = intrinsics.describe_size_fault(width, height)
        if fault or image is None:
            return LeftOut(picture.name, fault, intrinsics.where)
        lens = intrinsics.lens(width, height)
        return picture_of_view(picture, image, self._lenses.setdefault(lens, lens))

    def _read(self, picture: PosedPicture) -> Image:
        if picture.frame is None:
            return turned(read_picture(picture.path), picture.turns)
        return turned(self._videos.read(picture.frame), picture.turns)


def picture_of_view(picture: PosedPicture, image: Image, lens: Lens) -> View:
    """Return the view of a picture that was read, `image` (H, W), and the lens that took it."""
    height, width = image.shape
    share = KEPT_DIAGONAL_PX / float(np.hypot(width, height))
    if share >= 1.0:
        kept = lens.undistort(image)
        return View(picture.name, kept, lens.pinhole, picture.pose, None, picture.covariance)
    size = max(round(share * width), 1), max(round(share * height), 1)
    reduced = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    if picture.frame is None:
        read = partial(_read_again, picture.path, picture.turns, lens)
    else:
        read = partial(_unpack, cv2.imencode(".png", image)[1], lens)
    stored = StoredPicture(lens.pinhole, read)
    camera = lens.pinhole.resized(*size)
    kept = lens.undistort(reduced)
    return View(picture.name, kept, camera, picture.pose, stored, picture.covariance)


def _check_stored_size(picture: PosedPicture) -> str:
    """Return why a picture cannot be of its camera, by the size in its header; empty where it can
    be, or nothing is known before it is decoded.

    InputError for a picture that is too large for any.
    """
    size = stored_size(picture.path) if picture.frame is None else None
    if size is None or min(size) < LEAST_SIDE_PX:  # which is said when it is read
        return ""
    width, height = size[:: -1 if picture.turns % 2 else 1]
    return picture.intrinsics.describe_size_fault(width, height)


def _read_again(path: Path, turns: int, lens: Lens) -> Image:
    return lens.undistort(turned(read_picture(path), turns))


def _unpack(png: NDArray[np.uint8], lens: Lens) -> Image:
    # A video is fast only when read once in order: its frames are kept compressed.
    return lens.undistort(np.asarray(cv2.imdecode(png, cv2.IMREAD_GRAYSCALE), dtype=np.uint8))
