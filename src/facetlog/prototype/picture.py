"""A judged scene as a picture: what plays each part in a colour of its own, with a legend."""

from collections.abc import Mapping

import cv2

from facetlog.kb.explaining.verdict import Verdict
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.drawing.lettering import plain
from facetlog.perception.surfaces.drawing.thumbnail import (
    choose_tint_colour,
    put_on_white,
    thumbnail,
)

# Of the picture's side: a line of the legend, and its letters.
LINE, LETTERS = 0.035, 0.0011
INK = (40, 40, 40)


def role_faces(scene: Scene, verdict: Verdict) -> Mapping[str, tuple[int, ...]]:
    """Return the faces (indices) of what plays each part: itself, or those of a piece."""
    of_piece = _faces_of_pieces(scene) if _has_pieces(verdict) else {}
    found = {}
    for part in verdict.parts:
        names = [face for name in part.faces for face in of_piece.get(name, (name,))]
        found[part.role] = tuple(int(name[1:]) - 1 for name in names if name.startswith("f"))
    return {role: faces for role, faces in found.items() if faces}


def _has_pieces(verdict: Verdict) -> bool:
    return any(name.startswith("p") for part in verdict.parts for name in part.faces)


def _faces_of_pieces(scene: Scene) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for piece, face in fact_rows(scene, {"piece_face"})["piece_face"]:
        found.setdefault(str(piece), []).append(str(face))
    return found


def picture(scene: Scene, verdict: Verdict, size_px: int) -> bytes:
    """Return the scene on white as a PNG, with a legend of its parts; what plays none is grey."""
    roles = role_faces(scene, verdict)
    tints = {face: nth for nth, faces in reversed([*enumerate(roles.values())]) for face in faces}
    image = put_on_white(thumbnail(scene, size_px, tints))
    line = round(LINE * size_px)
    for nth, role in enumerate(roles):
        top = (nth + 1) * line
        box = (line, top), (2 * line - 8, top + line - 8)
        cv2.rectangle(image, *box, choose_tint_colour(nth).tolist(), cv2.FILLED)
        cv2.rectangle(image, *box, INK)
        start = (2 * line, top + line - 12)
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(image, plain(role), start, font, LETTERS * line * 20, INK, 1, cv2.LINE_AA)
    return cv2.imencode(".png", image)[1].tobytes()
