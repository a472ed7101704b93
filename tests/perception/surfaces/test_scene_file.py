"""Scenes out and in: every bit comes back, and a bad file is told in one line."""

import base64
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from facetlog.errors import InputError
from facetlog.perception.scene import (
    Edge,
    Evidence,
    Face,
    FaceSight,
    Plane,
    Scene,
    SeenLattice,
    SightLines,
    Vertex,
)
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, room_corner
from facetlog.perception.surfaces.scene_file import (
    SceneFileError,
    decode_scene,
    encode_scene,
    pack_bits,
    read_scene,
    write_scene,
)
from facetlog.perception.surfaces.scene_json.scene_checks import LARGEST
from facetlog.perception.surfaces.scene_json.scene_fault import MOST_COPIES
from facetlog.perception.types import Observation, PositionLabel

finite = st.floats(-LARGEST, LARGEST)
share = st.floats(0.0, 1.0)


def square(n: int) -> st.SearchStrategy[np.ndarray]:
    """A covariance: some A Aᵀ."""
    entries = st.floats(-LARGEST / n / 2, LARGEST / n / 2)

    def covariance(xs: list[float]) -> np.ndarray:
        a = np.array(xs).reshape(n, n)
        return a @ a.T

    return st.lists(entries, min_size=n * n, max_size=n * n).map(covariance)


def plate() -> Scene:
    """A square with a hole, whose corners are off its plane by rounding."""
    corners = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (1, 2), (2, 2), (2, 1)]
    vertices = tuple(Vertex(np.array([x, y, 0.1]), np.eye(3)) for x, y in corners)
    plane = Plane(np.array([0.0, 0.0, 1.0]), -0.1, np.eye(4))
    face = Face((0, 1, 2, 3), plane, holes=((4, 5, 6, 7),))
    return Scene("plate", vertices=vertices, faces=(face,))


@st.composite
def lattices(draw: st.DrawFn, views: int) -> SeenLattice:
    """Bits of views, of which there are so many, on a lattice."""
    named = draw(st.lists(st.integers(0, views - 1), max_size=2) if views else st.just([]))
    shape = len(named), draw(st.integers(1, 5)), draw(st.integers(1, 5))
    near = st.floats(-LARGEST / 5, LARGEST / 5)
    return SeenLattice(
        draw(arrays(np.float64, 3, elements=near)),
        draw(arrays(np.float64, (2, 3), elements=near)),
        draw(arrays(np.float64, (len(named), 3), elements=near)),
        draw(arrays(np.bool_, shape)),
        tuple(named),
        draw(st.none() | share),
        draw(st.booleans()),
    )


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Draw sound scenes, with all that geometry leaves open."""
    made = draw(st.sampled_from([cuboid, room_corner, plate]))()
    views = draw(st.lists(st.text(max_size=5), max_size=3))
    view = st.integers(0, max(len(views) - 1, 0))
    observations = st.builds(Observation, view, st.lists(finite, min_size=2, max_size=2), square(2))
    vertices = tuple(
        Vertex(
            vertex.point,
            draw(square(3)),
            tuple(draw(st.lists(observations, max_size=2 if views else 0))),
            draw(st.none() | st.sampled_from(PositionLabel)),
        )
        for vertex in made.vertices
    )
    evidence = st.sampled_from(Evidence)
    hidden = st.lists(st.tuples(st.just(0), share), max_size=1).map(tuple)
    sights = st.lists(
        st.builds(FaceSight, view, share, hidden, share), max_size=2 if views else 0
    ).map(tuple)
    faces = tuple(
        Face(
            face.outline,
            Plane(face.plane.normal, face.plane.offset, draw(square(4))),
            face.holes,
            draw(share),
            draw(share),
            draw(evidence),
            draw(sights),
        )
        for face in made.faces
    )
    single = st.floats(-float(np.float32(LARGEST / 2)), float(np.float32(LARGEST / 2)), width=32)
    lines = st.builds(
        SightLines,
        st.lists(finite, min_size=3, max_size=3),
        st.lists(st.tuples(single, single, single), max_size=3).map(
            lambda rows: np.array(rows).reshape(-1, 3)
        ),
        st.none() | view if views else st.none(),
    )
    index = st.integers(0, len(vertices) - 1)
    return Scene(
        draw(st.text(max_size=8)),
        tuple(views),
        vertices,
        tuple(draw(st.lists(st.builds(Edge, index, index, share, evidence), max_size=3))),
        faces,
        draw(st.none() | st.just(np.array([0.0, 0.6, 0.8]))),
        draw(st.booleans()),
        tuple(draw(st.lists(st.text(max_size=5), max_size=2))),
        sights=tuple(draw(st.lists(lines, max_size=2))),
        lattices=tuple(draw(st.lists(lattices(len(views)), max_size=2))),
    )


@settings(max_examples=20)
@given(scenes())
def test_a_scene_comes_back_bit_for_bit(scene: Scene) -> None:
    text = encode_scene(scene)
    back = decode_scene(text)
    assert encode_scene(back) == text
    assert [v.cov.tobytes() for v in back.vertices] == [v.cov.tobytes() for v in scene.vertices]


SEEN = {"view": 0, "uv": [0, 0], "cov": [[1, 0], [0, 1]]}


def _change(**changes: Any) -> str:
    return json.dumps({**json.loads(encode_scene(cuboid())), **changes})


def _lattice(**changes: Any) -> str:
    """A scene whose lattice of 2 x 3 points says that one view sees all."""
    square = {"corner": [0, 0, 0], "steps": [[1, 0, 0], [0, 1, 0]], "size": [2, 3]}
    shown = base64.b64encode(pack_bits(np.ones((1, 2, 3), dtype=np.bool_))).decode()
    lattice = {**square, "views": [0], "origins": [[0, 0, 9]], "shown": shown, **changes}
    return _change(views=["a.png"], lattices=[lattice])


def _bytes(count: int) -> str:
    return base64.b64encode(zlib.compress(bytes(count))).decode()


def test_a_lattice_is_read() -> None:
    (lines,) = decode_scene(_lattice()).lines_of_sight
    assert lines.view == 0
    assert lines.ends.tolist() == [[i, j, 0] for i in range(2) for j in range(3)]


def _broken(*path: str | int, value: Any) -> str:
    content = json.loads(encode_scene(cuboid()))
    place = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return json.dumps(content)


def _with_copies(count: int, *, own_vertices: bool) -> str:
    content = json.loads(encode_scene(cuboid()))
    vertices, faces = content["vertices"], content["faces"]
    for i in range(count):
        outline = faces[0]["outline"][i % 4 :] + faces[0]["outline"][: i % 4]
        if own_vertices:
            vertices += [vertices[i] for i in outline]
            outline = list(range(len(vertices) - 4, len(vertices)))
        faces.append({**faces[0], "outline": outline})
    return json.dumps(content)


@pytest.mark.parametrize("own_vertices", [False, True])
def test_many_faces_with_the_same_corners_are_refused_and_a_few_are_read(
    own_vertices: bool,
) -> None:
    few = _with_copies(MOST_COPIES - 1, own_vertices=own_vertices)
    assert len(decode_scene(few).faces) == 6 + MOST_COPIES - 1
    with pytest.raises(SceneFileError, match=r"has the corners of face 0, as 3000 others: remove"):
        decode_scene(_with_copies(3000, own_vertices=own_vertices))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (_change()[:-40], r"\$: Invalid JSON: .*: it is cut short, write the scene again$"),
        (_change(schema="facetlog-scene/9"), r"\$\.schema: .*'facetlog-scene/1'"),
        (_change(extra=1), r"\$\.extra: "),
        (_broken("vertices", 3, "point", 1, value="x"), r"\$\.vertices\[3\]\.point\[1\]: "),
        (_broken("faces", 2, "outline", 0, value=99), r"\$\.faces\[2\]\.outline: vertex 99 "),
        (_broken("faces", 2, "outline", value=[1, 2, 2]), r"\$\.faces\[2\]: an outline is"),
        (_broken("faces", 1, "plane", "normal", value=[2, 0, 0]), r"\$\.faces\[1\]\.plane: "),
        (_broken("faces", 1, "support", value=1.5), r"\$\.faces\[1\]\.support: "),
        (
            _broken("faces", 0, "sights", value=[{"view": 2, "seen": 1}]),
            r"\$\.faces\[0\]\.sights\[0\]\.view: view 2 ",
        ),
        (
            _change(sights=[{"origin": [0, 0, 0], "ends": "A!AA\n"}]),
            r"\$\.sights\[0\]\.ends: is no base64$",
        ),
        (
            _change(sights=[{"origin": [0, 0, 0], "ends": "AAAA"}]),
            r"\$\.sights\[0\]\.ends: give base64 of finite float32",
        ),
        (_lattice(shown="AAAA"), r"\$\.lattices\[0\]\.shown: is not compressed by zlib$"),
        (_lattice(shown=_bytes(1_000_000)), r"\$\.lattices\[0\]\.shown: does not hold 6 bits$"),
        (
            _lattice(size=[1 << 40, 1 << 40]),
            r"\$\.lattices\[0\]\.shown: there are more than 16777216 bits in all lattices$",
        ),
        (_lattice(views=[1]), r"\$\.lattices\[0\]\.views: view 1 does not exist"),
        (_lattice(origins=[]), r"\$\.lattices\[0\]\.origins: 0 origins and 1 views: "),
        (_lattice(steps=[[1e308, 0, 0], [0, 1, 0]]), r"\$\.lattices\[0\]\.steps: is beyond "),
        (
            _broken("vertices", 0, "observations", value=[SEEN]),
            r"\$\.vertices\[0\]\.observations\[0\]\.view: view 0 ",
        ),
        (_broken("vertices", 0, "point", 0, value=float("nan")), r"\$"),
    ],
)  # fmt: skip
def test_a_bad_file_is_told_by_name_and_place(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"bad\.json: {message}") as caught:
        read_scene(path)
    assert "\n" not in str(caught.value)


def test_a_failed_write_leaves_the_older_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    write_scene(cuboid(), path)
    before = path.read_bytes()
    bad = Scene("bad", vertices=(Vertex([np.nan, 0, 0], np.eye(3)),))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="JSON"):
        write_scene(bad, path)
    assert path.read_bytes() == before
    with pytest.raises(InputError, match="cannot be written"):
        write_scene(cuboid(), tmp_path / "no" / "scene.json")
    assert [p.name for p in tmp_path.iterdir()] == ["scene.json"]
    assert encode_scene(read_scene(path)) == encode_scene(cuboid())
    with pytest.raises(InputError, match=r"no\.json: cannot be read: No such file"):
        read_scene(tmp_path / "no.json")
