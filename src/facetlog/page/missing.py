"""Where what was not seen of a thing would be: in unseen space, or seen from a direction."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import trimesh

from facetlog.kb.explaining.sight import Point
from facetlog.kb.explaining.unseen import Unseen
from facetlog.kb.explaining.verdict import Verdict
from facetlog.perception.pieces.shown_pieces import ShownPieces
from facetlog.perception.scene import Scene
from facetlog.perception.space.space import State
from facetlog.perception.types import FloatArray

__all__ = ["Look", "Missing", "add_arrows"]

_align: Callable[..., FloatArray] = trimesh.geometry.align_vectors  # trimesh: without types

# An arrow's length, and how far its tip is from the thing, as shares of the scene's diagonal.
ARROW_SHARE, GAP_SHARE = 0.16, 0.03
# Of an arrow of length 1 the head's length, and the radii of head and shaft.
HEAD, HEAD_WIDE, SHAFT_WIDE = 0.4, 0.14, 0.05
SIDES = 16
NAME_AT = 1.25  # its name stands beyond its tail
COLOUR = (230, 120, 20, 255)


@dataclass(frozen=True, slots=True)
class Look:
    """A direction (a unit vector from the thing) to look from, and its name: look1, …."""

    name: str
    thing: str
    direction: Point


@dataclass(frozen=True, slots=True)
class Missing:
    """What can be lit up of what was not seen: `looks`, and by thing the name of unseen space."""

    looks: tuple[Look, ...]
    spaces: dict[str, str]

    @classmethod
    def of(cls, verdicts: Iterable[Verdict], pieces: ShownPieces) -> "Missing":
        """That of all verdicts on the things of a scene; each direction once."""
        said = dict.fromkeys(
            (v.thing, found.direction) for v in verdicts for found in v.unseen if found.direction
        )
        looks = (Look(f"look{k}", thing, way) for k, (thing, way) in enumerate(said, start=1))
        spaces = {
            thing: f"unseen{number}"
            for number, (thing, space) in enumerate(
                zip(pieces.things, pieces.spaces, strict=True), start=1
            )
            if (space.cells == State.UNSEEN).any()
        }
        return cls(tuple(looks), spaces)

    def names(self, thing: str, found: Unseen) -> Iterator[str]:
        """What to light up for a reason why something of the thing was missed, if anything."""
        if found.space and thing in self.spaces:
            yield self.spaces[thing]
        yield from (
            look.name
            for look in self.looks
            if (look.thing, look.direction) == (thing, found.direction)
        )


def add_arrows(
    graph: trimesh.Scene, scene: Scene, pieces: ShownPieces, looks: Iterable[Look]
) -> None:
    """Adds nodes look1, … in the scene's frame: arrows that point at the thing from there."""
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    for look in looks:
        points = _surface(scene, pieces, look.thing)
        towards = np.array(look.direction)
        middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
        reach = float(((points - middle) @ towards).max())
        tip = middle + (reach + GAP_SHARE * size) * towards
        graph.add_geometry(_arrow(tip, towards, ARROW_SHARE * size), node_name=look.name)


def _surface(scene: Scene, pieces: ShownPieces, thing: str) -> FloatArray:
    """Points (n, 3) of a thing, of the whole scene where its space is not known."""
    if thing in pieces.things:
        space = pieces.spaces[pieces.things.index(thing)]
        full = np.argwhere(space.cells == State.FULL)
        if len(full):
            return np.asarray(((full + 0.5) * space.cell + space.corner) @ space.axes)
    return scene.points


def _arrow(tip: FloatArray, towards: FloatArray, length: float) -> trimesh.Trimesh:
    """An arrow whose tip is there and whose tail lies `towards` (3,), a unit vector, of it."""
    # Radius and distance from the tip, turned round: head, neck, shaft, end.
    profile = [(0, 0), (HEAD_WIDE, HEAD), (SHAFT_WIDE, HEAD), (SHAFT_WIDE, 1), (0, 1)]
    round_z = trimesh.creation.revolve(length * np.array(profile, dtype=np.float64), sections=SIDES)
    turn = _align([0.0, 0.0, 1.0], towards)[:3, :3]
    colours = np.tile(np.array(COLOUR, dtype=np.uint8), (len(round_z.faces), 1))
    corners = tip + round_z.vertices @ turn.T
    mesh = trimesh.Trimesh(corners, round_z.faces, face_colors=colours, process=False)
    mesh.metadata["at"] = (tip + NAME_AT * length * towards).tolist()
    return mesh
