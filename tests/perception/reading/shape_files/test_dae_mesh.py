"""COLLADA: polygons of each kind, nodes shown again, and controllers."""

from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from tests.perception.reading.shape_files.mesh_measures import area, extent, read

# An L of area 3 in the plane z = 0, and the corners of a hole of area .25 in it.
POINTS = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
HOLE = [(0.25, 0.25, 0), (0.75, 0.25, 0), (0.75, 0.75, 0), (0.25, 0.75, 0)]
INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'
IDENTITY = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"


def source(name: str, values: object, width: int) -> str:
    flat = np.asarray(values, dtype=float).ravel()
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ"[:width])
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{len(flat)}">'
        f"{' '.join(map(str, flat))}</float_array><technique_common>"
        f'<accessor source="#{name}-a" count="{len(flat) // width}" stride="{width}">{params}'
        "</accessor></technique_common></source>"
    )


def names(name: str, words: str) -> str:
    return f'<source id="{name}"><Name_array id="{name}-a">{words}</Name_array></source>'


def geometry(primitive: str, points: object = (*POINTS, *HOLE), name: str = "g") -> str:
    v = "v" if name == "g" else f"v{name}"
    return (
        f'<geometry id="{name}"><mesh>{source(f"p{name}", points, 3)}<vertices id="{v}">'
        f'<input semantic="POSITION" source="#p{name}"/></vertices>{primitive}</mesh></geometry>'
    )


def document(geometries: str, nodes: str, more: str = "") -> bytes:
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        'version="1.4.1"><asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>'
        f"<library_geometries>{geometries}</library_geometries>{more}<library_visual_scenes>"
        f'<visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    ).encode()


SHOWN = '<node><instance_geometry url="#g"/></node>'
L_LIST = f'<polylist count="1">{INPUT}<vcount>6</vcount><p>0 1 2 3 4 5</p></polylist>'


@pytest.mark.parametrize(
    ("primitive", "size"),
    [
        (L_LIST, 3.0),
        (f'<polylist count="1">{INPUT}<vcount>6</vcount><p>2 3 4 5 0 1</p></polylist>', 3.0),
        (f'<polygons count="1">{INPUT}<p>0 1 2 3 4 5</p></polygons>', 3.0),
        (
            f'<polygons count="2">{INPUT}<ph><p>3 4 5 0 1 2</p><h>6 7 8 9</h></ph>'
            "<p>6 7 8 9</p></polygons>",
            3.0,
        ),
        (f'<polygons count="1">{INPUT}<ph><p>0 1 2 3 4 5</p><h>9 8 7 6</h></ph></polygons>', 2.75),
        (f'<triangles count="2">{INPUT}<p>0 1 2 0 2 3</p></triangles>', 1.5),
        (f'<trifans count="1">{INPUT}<p>0 1 2 3</p></trifans>', 1.5),
        (f'<tristrips count="1">{INPUT}<p>6 7 9 8</p></tristrips>', 0.25),
        (
            '<polylist count="1"><input semantic="NORMAL" source="#pg" offset="0"/>'
            '<input semantic="VERTEX" source="#v" offset="1"/><vcount>6</vcount>'
            "<p>0 0 0 1 0 2 0 3 0 4 0 5</p></polylist>",
            3.0,
        ),
    ],
)
def test_polygons_of_each_kind(tmp_path: Path, primitive: str, size: float) -> None:
    mesh = read(tmp_path, "made.dae", document(geometry(primitive), SHOWN))
    assert area(mesh) == pytest.approx(size)
    assert mesh.up is not None
    assert (mesh.up.tolist(), mesh.unit_metres) == ([0.0, 0.0, 1.0], 0.01)
    assert mesh.warnings == ()


def test_nodes_move_what_they_show_in_their_order(tmp_path: Path) -> None:
    nodes = (
        "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
        '<instance_node url="#leg"/></node><node id="leg"><matrix>1 0 0 0 0 1 0 0 0 0 1 5 0 0 0 1'
        '</matrix><instance_geometry url="#g"/></node>'
    )
    mesh = read(tmp_path, "made.dae", document(geometry(L_LIST), nodes))
    assert area(mesh) == pytest.approx(6.0 + 3.0)
    assert mesh.vertices[:10].min(axis=0) == pytest.approx([8, 0, 5])
    assert mesh.vertices[:10].max(axis=0) == pytest.approx([10, 4, 5])


def test_nodes_that_show_themselves_are_refused(tmp_path: Path) -> None:
    nodes = '<node id="n"><instance_node url="#n"/></node>'
    with pytest.raises(InputError, match="without end"):
        read(tmp_path, "made.dae", document(geometry(L_LIST), nodes))


def skin(joints: str, weights: str, counts: str) -> str:
    matrices = np.stack([np.eye(4), np.eye(4)])
    matrices[1, 2, 3] = -50.0
    return (
        f'<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>'
        f"{IDENTITY}</bind_shape_matrix>{names('j', joints)}{source('m', matrices, 16)}"
        f"{source('w', [1, 0.5], 1)}"
        '<joints><input semantic="JOINT" source="#j"/><input semantic="INV_BIND_MATRIX" '
        'source="#m"/></joints><vertex_weights count="6"><input semantic="JOINT" source="#j" '
        f'offset="0"/><input semantic="WEIGHT" source="#w" offset="1"/><vcount>{counts}</vcount>'
        f"<v>{weights}</v></vertex_weights></skin></controller></library_controllers>"
    )


JOINTS = (
    '<node id="a" sid="A"><scale>.1 .1 .1</scale><node id="b" sid="B"><translate>0 0 50</translate>'
    "</node></node>"
)
CONTROLLED = (
    '<node><scale>9 9 9</scale><instance_controller url="#c"><skeleton>#a</skeleton>'
    "</instance_controller></node>"
)


@pytest.mark.parametrize("first", ["", '<node sid="B"><translate>77 0 0</translate></node>'])
def test_a_skin_is_placed_by_its_joints(tmp_path: Path, first: str) -> None:
    """Under an armature of a tenth; the node of the controller does not move it."""
    made = skin("A B", "0 0 1 0 0 1 1 1 0 0 1 0 0 0", "1 1 2 1 1 1")
    content = document(geometry(L_LIST, POINTS), first + JOINTS + CONTROLLED, made)
    mesh = read(tmp_path, "made.dae", content)
    assert extent(mesh) == pytest.approx([0, 0, 0, 0.2, 0.2, 0])
    assert mesh.warnings == ()


def test_a_skin_without_its_joints_is_read_as_bound_and_named(tmp_path: Path) -> None:
    made = skin("A gone", "0 0 1 0 0 1 1 1 0 0 1 0 0 0", "1 1 2 1 1 1")
    mesh = read(tmp_path, "made.dae", document(geometry(L_LIST, POINTS), JOINTS + CONTROLLED, made))
    assert extent(mesh) == pytest.approx([0, 0, 0, 18, 18, 0])
    assert "joint gone" in mesh.warnings[0]


@pytest.mark.parametrize("method", ["NORMALIZED", "RELATIVE"])
def test_a_morph_is_applied(tmp_path: Path, method: str) -> None:
    target = 3.0 * np.array(POINTS) if method == "NORMALIZED" else np.array(POINTS, dtype=float)
    made = (
        f'<library_controllers><controller id="c"><morph method="{method}" source="#g">'
        f'<source id="t"><IDREF_array id="t-a">h</IDREF_array></source>{source("w", [0.5], 1)}'
        '<targets><input semantic="MORPH_TARGET" source="#t"/>'
        '<input semantic="MORPH_WEIGHT" source="#w"/></targets></morph></controller>'
        "</library_controllers>"
    )
    shapes = geometry(L_LIST, POINTS) + geometry("", target, "h")
    nodes = '<node><instance_controller url="#c"/></node>'
    factor = 2.0 if method == "NORMALIZED" else 1.5
    mesh = read(tmp_path, "made.dae", document(shapes, nodes, made))
    assert extent(mesh) == pytest.approx([0, 0, 0, 2 * factor, 2 * factor, 0])


@pytest.mark.parametrize(
    ("primitive", "said"),
    [
        (f'<triangles count="3">{INPUT}<p>0 1 2 0 2 3</p></triangles>', "2 of the 3"),
        (f'<triangles count="2">{INPUT}<p>0 1 2 0 2</p></triangles>', "inconsistent"),
        (f'<triangles count="1">{INPUT}<p>0 1 10</p></triangles>', "none of 10"),
        (f'<polylist count="2">{INPUT}<vcount>3 4</vcount><p>0 1 2 3</p></polylist>', "vcount"),
        (f'<triangles count="1">{INPUT}<p>0 1,5 2</p></triangles>', "decimal commas"),
    ],
)
def test_what_does_not_fit_is_named(tmp_path: Path, primitive: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(tmp_path, "made.dae", document(geometry(primitive), SHOWN))


def test_damaged_xml_is_refused_with_its_place(tmp_path: Path) -> None:
    whole = document(geometry(L_LIST), SHOWN)
    with pytest.raises(InputError, match=r"truncated or damaged \(.*line 1"):
        read(tmp_path, "made.dae", whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"is COLLADA 1\.3"):
        read(tmp_path, "made.dae", whole.replace(b"1.4.1", b"1.3.0"))
    with pytest.raises(InputError, match="has a document type"):
        read(
            tmp_path,
            "made.dae",
            whole.replace(b"<COLLADA", b'<!DOCTYPE x [<!ENTITY a "a">]><COLLADA'),
        )
    with pytest.raises(InputError, match="refers to another file"):
        read(tmp_path, "made.dae", whole.replace(b'url="#g"', b'url="other.dae#g"'))
