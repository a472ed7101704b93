"""The faces found, with the boards between those that stand upright opposite each other."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.boards_between import BoardSearch, Sight
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceJudge
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.outlines.outline_search import MIN_SIDE_PX
from facetlog.perception.detection.line_front_end.planes.board_places import board_places
from facetlog.perception.detection.line_front_end.planes.ground_plane import LEVEL_COSINE, Ground
from facetlog.perception.detection.line_front_end.selected_face import SelectedFace
from facetlog.perception.flat_faces import vector_area
from facetlog.perception.types import FloatArray


def with_boards(
    faces: Sequence[SelectedFace],
    photos: PhotometricViews,
    sides: SideJudge,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    behind: LinesBehind,
    pixel: float,
) -> tuple[SelectedFace, ...]:
    """Return the `faces`, and the level boards between those that stand upright opposite each
    other.

    `taken` are the pixels that found faces explain, V pictures of 0 and 1; `pixel` is a pixel's
    length at the usual distance. Without a ground nothing says what is level: then as they are.
    """
    if ground is None:
        return tuple(faces)
    up = _level(faces, ground)
    places = board_places(faces, up, pixel, MIN_SIDE_PX * pixel)
    if not len(places.rings):
        return tuple(faces)
    sight = Sight(photos, sides, FaceJudge(photos, sides, ground), behind, taken, ground, pixel)
    found: list[SelectedFace] = []
    for normal in (up, -up):
        found += BoardSearch((*faces, *found), places, normal, sight).run()
    return (*faces, *found)


def _level(faces: Sequence[SelectedFace], ground: Ground) -> FloatArray:
    # A normal (3,) upwards: of the largest level face that was found, for a floor that is seen from
    # afar may be known worse; else the ground's.
    best, most = ground.normal, 0.0
    for face in faces:
        area = float(np.linalg.norm(vector_area(face.corners)))
        if area > most and abs(face.normal @ ground.normal) > LEVEL_COSINE:
            best, most = np.sign(face.normal @ ground.normal) * face.normal, area
    return best
