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

from facetlog.perception.reading.lens import Lens
from facetlog.perception.reading.picture_file import (
    LEAST_SIDE_PX,
    read_picture,
    stored_size,
    turned,
)
from facetlog.perception.reading.pose_files.poses_file import PosedPicture
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.types import Image, StoredPicture, View

__all__ = ["KEPT_DIAGONAL_PX", "picture_as_stored", "picture_of_view", "stored_size_fault"]

KEPT_DIAGONAL_PX = 1000.0
"""Larger pictures are reduced to it, as 800 x 600: a bound of cost alone. 12 bytes a pixel are kept
(detection/edge_maps.py and others), so that 200 views fill 1.2 GB."""


def picture_of_view(picture: PosedPicture, image: Image, lens: Lens) -> View:
    """The view of a picture that was read, `image` (H, W), and the lens that took it."""
    height, width = image.shape
    share = KEPT_DIAGONAL_PX / float(np.hypot(width, height))
    if share >= 1.0:
        kept = lens.undistort(image)
        return View(picture.name, kept, lens.pinhole, picture.pose, None, picture.covariance)
    size = max(round(share * width), 1), max(round(share * height), 1)
    reduced = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    if picture.frame is None:
        read = partial(_read, picture.path, picture.turns, lens)
    else:
        read = partial(_unpacked, cv2.imencode(".png", image)[1], lens)
    stored = StoredPicture(lens.pinhole, read)
    camera = lens.pinhole.resized(*size)
    kept = lens.undistort(reduced)
    return View(picture.name, kept, camera, picture.pose, stored, picture.covariance)


def stored_size_fault(picture: PosedPicture) -> str:
    """Why a picture cannot be of its camera, by the size in its header; empty where it can be, or
    nothing is known before it is decoded.

    InputError for a picture that is too large for any.
    """
    size = stored_size(picture.path) if picture.frame is None else None
    if size is None or min(size) < LEAST_SIDE_PX:  # which is said when it is read
        return ""
    width, height = size[:: -1 if picture.turns % 2 else 1]
    return picture.intrinsics.size_fault(width, height)


def picture_as_stored(picture: PosedPicture, videos: VideoFrames) -> Image:
    """The picture of a file or video, (H, W); InputError if it cannot be had."""
    image = read_picture(picture.path) if picture.frame is None else videos.read(picture.frame)
    return turned(image, picture.turns)


def _read(path: Path, turns: int, lens: Lens) -> Image:
    return lens.undistort(turned(read_picture(path), turns))


def _unpacked(png: NDArray[np.uint8], lens: Lens) -> Image:
    # A video is fast only when read once in order: its frames are kept compressed.
    return lens.undistort(np.asarray(cv2.imdecode(png, cv2.IMREAD_GRAYSCALE), dtype=np.uint8))
