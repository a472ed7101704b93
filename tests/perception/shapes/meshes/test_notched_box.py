"""A box whose edges are interrupted is as large as the solid, not as a piece of an edge."""

import numpy as np
import pytest
import trimesh

from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene

SIZE = (0.4, 0.3, 0.25)
NOTCH = 0.01


def notched_box() -> trimesh.Trimesh:
    """A box with a notch in the middle of each edge, as solids that touch."""
    inner = [np.array([0.0, s / 2 - NOTCH, s / 2 + NOTCH, s]) for s in SIZE]
    cells = []
    for i in range(3):
        for j in range(3):
            for k in range(3):
                place = (i, j, k)
                if sum(n == 1 for n in place) == 1:  # the middle of an edge
                    continue
                low = [inner[axis][n] for axis, n in enumerate(place)]
                high = [inner[axis][n + 1] for axis, n in enumerate(place)]
                cells.append(trimesh.creation.box(bounds=[low, high]))
    # the middles of sides go to the edges of the notches
    for axis in range(3):
        low, high = np.full(3, NOTCH), np.array(SIZE) - NOTCH
        low[axis], high[axis] = 0.0, SIZE[axis]
        cells.append(trimesh.creation.box(bounds=[low, high]))
    return trimesh.util.concatenate(cells)


@pytest.mark.slow
def test_a_box_with_notched_edges_has_the_extents_of_the_solid() -> None:
    made = notched_box()
    scene = make_mesh_scene(Mesh.of(made.vertices, made.faces), up=(0, 0, 1), metric=True)
    with open_knowledge_base() as base:
        found = judge_scene(base, "s", [fact.row for fact in scene_facts(scene)])
    (box,) = (verdict for verdict in found.verdicts if verdict.model == "box")
    assert [size.value for size in box.sizes] == pytest.approx(SIZE, abs=1e-4)


def test_a_box_of_sheets_without_a_bottom_is_as_high_as_its_walls() -> None:
    made = trimesh.creation.box(SIZE)
    made.update_faces(made.face_normals[:, 2] > -0.5)
    made.apply_transform(trimesh.transformations.rotation_matrix(0.9, (0, 0, 1)))
    scene = make_mesh_scene(Mesh.of(made.vertices, made.faces), up=(0, 0, 1), metric=True)
    tops = {f"f{n + 1}" for n, face in enumerate(scene.faces) if face.plane.normal[2] > 0.9}
    facts = scene_facts(scene)
    reaches = [f.args[1] for f in facts if f.functor == "reach_behind" and f.args[0] in tops]
    assert reaches == pytest.approx([SIZE[2]])
