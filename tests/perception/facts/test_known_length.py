"""A known length makes metres of a scene whose unit is unknown."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.known_length import KnownLength, scale_by_known_length
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build


@pytest.fixture(scope="module")
def table() -> Scene:
    """A table of which lengths mean nothing, with vertices that are known to 2e-3."""
    made = build("table", {})
    vertices = tuple(replace(v, cov=4e-6 * np.eye(3)) for v in made.vertices)
    return replace(made, vertices=vertices, metric=False)


def _height(scene: Scene) -> float:
    assert scene.up is not None
    return float(np.ptp(scene.points @ scene.up))


@pytest.mark.parametrize(
    ("text", "metres", "sd"),
    [
        ("v1 v2 = 25 cm", 0.25, 0.0),
        (" v1 v2=.5in", 0.0127, 0.0),
        ("height = 74 ± 0.5 mm", 0.074, 0.0005),
        ("height t2 = 2 +- 0.1 ft", 0.6096, 0.03048),
        ("e5 = 1. +/- .5 m", 1.0, 0.5),
    ],
)
def test_lengths_are_read(text: str, metres: float, sd: float) -> None:
    known = KnownLength.parse(text)
    assert (known.metres, known.sd) == (pytest.approx(metres), pytest.approx(sd))


@pytest.mark.parametrize(
    "text", ["", "v1 v2 25 cm", "v1 v2 = cm", "v1 = 2 yd", "e1 = 0 cm", "=1 m"]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--scale "):
        KnownLength.parse(text)


def test_the_length_that_is_known_is_that_long_then(table: Scene) -> None:
    for text, of in (("v1 v2 = 25 cm", 0.25), ("v2 v1 = 2 m", 2.0)):
        scene, scale = scale_by_known_length(table, KnownLength.parse(text))
        points = scene.points
        assert np.linalg.norm(points[1] - points[0]) == pytest.approx(of)
        assert scene.metric
        np.testing.assert_allclose(points, table.points * scale.metres)
    high, _ = scale_by_known_length(table, KnownLength.parse("height t1 = 1.5 m"))
    assert _height(high) == pytest.approx(1.5)
    edge = table.edges[4]
    by_edge, _ = scale_by_known_length(table, KnownLength.parse("e5 = 3 m"))
    length = np.linalg.norm(by_edge.points[edge.end] - by_edge.points[edge.start])
    assert length == pytest.approx(3.0)


def test_the_scale_is_as_sure_as_both_lengths(table: Scene) -> None:
    high = _height(table)
    measured = np.sqrt(2) * 2e-3 / high  # two vertices of 2e-3 each
    _, exact = scale_by_known_length(table, KnownLength.parse("height = 2 m"))
    assert exact.sd / exact.metres == pytest.approx(measured)
    _, about = scale_by_known_length(table, KnownLength.parse("height = 2 ± 0.1 m"))
    assert about.sd / about.metres == pytest.approx(np.hypot(measured, 0.05))


def test_all_lengths_are_as_unsure_as_the_scale_and_areas_twice(table: Scene) -> None:
    exact, unsure = (
        fact_rows(scale_by_known_length(table, KnownLength.parse(text))[0])
        for text in ("height = 75 cm", "height = 75 ± 30 cm")
    )
    for functor, power in (("edge_length", 1), ("elevation", 1), ("top_of", 1), ("area", 2)):
        for before, after in zip(exact[functor], unsure[functor], strict=True):
            value, sd = map(float, after[-2:])
            assert before[:-1] == after[:-1]
            both = np.hypot(float(before[-1]), power * 0.4 * value)
            assert sd == pytest.approx(both, rel=1e-3)
    for functor in ("angle", "share", "fill", "plane", "point_cov"):
        assert exact[functor] == unsure[functor]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("v1 v99 = 1 m", r"no vertex 'v99': they are v1 to v\d+"),
        ("e99 = 1 m", r"no edge 'e99': they are e1 to"),
        ("height t7 = 1 m", r"no thing 't7': they are t1 to t1"),
        ("width = 1 m", r"'width' is no length in a scene: give \"v3 v7"),
        ("v1 v1 = 1 m", "v1 v1 is of length 0 here"),
    ],
)
def test_what_the_scene_has_not_is_named(table: Scene, text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        scale_by_known_length(table, KnownLength.parse(text))


def test_metres_and_a_height_without_up_are_refused(table: Scene) -> None:
    known = KnownLength.parse("height = 1 m")
    with pytest.raises(InputError, match="metres already"):
        scale_by_known_length(replace(table, metric=True), known)
    with pytest.raises(InputError, match="not known without up"):
        scale_by_known_length(replace(table, up=None), known)
