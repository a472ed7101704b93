"""What stands at the origin is answered, and the cuboids beside it are found where they are."""

from dataclasses import replace

from benchmarks.pictures.accuracy_furniture import of_scene
from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved, table, together

CUBOID = {"centre": [2.0, 1.0, 0.2], "half_sides": [0.2, 0.25, 0.2], "turn_z_deg": 0.0}
ELSEWHERE = {**CUBOID, "centre": [2.0, -1.0, 0.2]}


def beside_it(x: float, y: float) -> Scene:
    """A table on the origin, and a box with its middle there."""
    box = moved(cuboid(0.4, 0.5, 0.4), translation=(x - 0.2, y - 0.25, 0.0))
    scene = together(moved(table(), translation=(-0.6, -0.4, 0.0)), box)
    return replace(scene, name="04", metric=True)


def test_the_thing_at_the_origin_is_answered_and_boxes_count_where_they_are() -> None:
    judge = BatchJudge()
    truth = {"label": "table", "other_boxes": [CUBOID, ELSEWHERE]}
    found = of_scene(beside_it(2.0, 1.0), truth, judge)
    assert (found.answer, found.right, found.wrong) == ("table", True, False)
    assert (found.boxes, found.beside, found.half) == (1, 2, "even")
    assert of_scene(beside_it(2.3, 1.0), truth, judge).boxes == 0
    # one box is no two
    twice = {"label": "chair", "other_boxes": [CUBOID, CUBOID]}
    found = of_scene(beside_it(2.0, 1.0), twice, judge)
    assert (found.boxes, found.right, found.wrong) == (1, False, True)
