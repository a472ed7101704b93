"""The faces found, with the boards between them, and without fronts that one sees through.

A shelf of one shade is as plain from the front as a closed cabinet: its opening, bounded by edges,
may be taken for a face, which then hides the boards. Without it boards may be found by rims that
could as well be lines printed on it. But where a board meets the rear, it shows a second edge, and
print is not there by chance for all that.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.boards_between import BoardSearch, Sight
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import blocked
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceJudge
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import (
    LEAST_SCORE,
    LinesBehind,
)
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.face_selection import FREE_PX, SelectedFace
from facetlog.perception.detection.line_front_end.outlines.outline_search import MIN_SIDE_PX
from facetlog.perception.detection.line_front_end.planes.board_places import (
    UPRIGHT_SINE,
    BoardPlaces,
    board_places,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import (
    LEVEL_COSINE,
    Ground,
)
from facetlog.perception.flat_faces import vector_area
from facetlog.perception.types import FloatArray

__all__ = ["with_boards"]


def with_boards(
    faces: Sequence[SelectedFace],
    photos: PhotometricViews,
    sides: SideJudge,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    behind: LinesBehind,
    pixel: float,
) -> tuple[SelectedFace, ...]:
    """The `faces` without false fronts, and the level boards between those that stand upright
    opposite each other.

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
    false = [
        front
        for pair in np.unique(places.pair)
        for front in _false_fronts(faces, _of_pair(places, int(pair)), up, sight)
    ]
    kept = [face for face in faces if not any(face is front for front in false)]
    found: list[SelectedFace] = []
    for normal in (up, -up):
        found += BoardSearch((*kept, *found), places, normal, sight).run()
    return (*kept, *found)


def _level(faces: Sequence[SelectedFace], ground: Ground) -> FloatArray:
    # A normal (3,) upwards: of the largest level face that was found, for a floor that is seen from
    # afar may be known worse; else the ground's.
    best, most = ground.normal, 0.0
    for face in faces:
        area = float(np.linalg.norm(vector_area(face.corners)))
        if area > most and abs(face.normal @ ground.normal) > LEVEL_COSINE:
            best, most = np.sign(face.normal @ ground.normal) * face.normal, area
    return best


def _of_pair(places: BoardPlaces, pair: int) -> BoardPlaces:
    of_pair = places.pair == pair
    return BoardPlaces(places.rings[of_pair], places.pair[of_pair])


def _false_fronts(
    faces: Sequence[SelectedFace], places: BoardPlaces, up: FloatArray, sight: Sight
) -> list[SelectedFace]:
    # The upright faces across two opposite ones behind which one sees where boards end.
    side = places.free_sides[0, 0]
    across = (side[1] - side[0]) / np.linalg.norm(side[1] - side[0])
    fronts = [
        face
        for face in faces
        if abs(face.normal @ up) < UPRIGHT_SINE
        and abs(face.normal @ across) < UPRIGHT_SINE
        and _hides(face, places, sight)
    ]
    if not fronts:
        return []
    others = [face for face in faces if not any(face is front for front in fronts)]
    search = BoardSearch(others, places, up, sight)
    boards = search.run()
    if not boards:
        return []
    seen: list[FloatArray] = [
        np.sum([search.seen_beyond(front, board) for board in boards], axis=0) for front in fronts
    ]
    return [
        front
        for front, ratio in zip(fronts, seen, strict=True)
        if ratio.max() > LEAST_SCORE + np.log(len(ratio))
    ]


def _hides(face: SelectedFace, places: BoardPlaces, sight: Sight) -> bool:
    middles = places.rings.mean(axis=1)
    margin, centres = FREE_PX * sight.pixel, sight.photos.centres
    return bool(blocked(face.corners, face.normal, middles, centres, margin, face.holes).any())
