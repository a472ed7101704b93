"""Mesh files in text: encodings, indices, comments, counts that do not fit."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from trimesh.exchange import stl

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh, read_mesh
from tests.perception.reading.shape_files.mesh_measures import (
    area,
    area_vectors,
    block,
    read,
)


def shown(mesh: Mesh) -> np.ndarray:
    """Its triangles as places (m, 3, 3), in an order that says nothing of how they were written."""
    corners = np.asarray(mesh.vertices[mesh.triangles])
    return corners[np.lexsort(corners.reshape(-1, 9).T)]


def groups(count: int, *, relative: bool) -> bytes:
    """Blocks beside each other: vertices, texture and faces of each; relative ones over 3 lines."""
    made, lines = block(), []
    for nth in range(count):
        lines.append(f"o part{nth}")
        lines += [f"v {x + 10 * nth} {y} {z}" for x, y, z in made.vertices]
        lines += [f"vt 0.{k} 0.5" for k in range(4 + nth)] + ["vn 0 0 1 # 0"]
        for face in made.faces.tolist():
            if relative:
                lines.append("f " + " \\\n  ".join(f"{k - 8}/-{1 + k % 4}/-1" for k in face))
            else:
                lines.append("f " + " ".join(str(k + 1 + 8 * nth) for k in face))
    return "\n".join(["# C:\\models\\", *lines]).encode()


def test_negative_indices_of_an_obj_count_from_their_line(tmp_path: Path) -> None:
    meant = read(tmp_path, "absolute.obj", groups(3, relative=False))
    found = read(tmp_path, "relative.obj", groups(3, relative=True))
    assert len(found.triangles) == 36
    assert np.array_equal(shown(found), shown(meant))


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whichever_indices_are_negative_the_mesh_is_the_same(
    tmp_path: Path, data: st.DataObject
) -> None:
    made = block()
    places = [f"v {x} {y} {z}" for x, y, z in made.vertices]
    ends = ("\n", "\r\n")
    plain, mixed = list(places), list(places)
    for face in made.faces:
        plain.append("f " + " ".join(str(k + 1) for k in face))
        turned = [data.draw(st.booleans()) for _ in face]
        words = [str(k - 8 if t else k + 1) for k, t in zip(face, turned, strict=True)]
        mixed.append("f " + data.draw(st.sampled_from((" ", "\t", " \\\n"))).join(words))
    meant = read(tmp_path, "plain.obj", "\n".join(plain).encode())
    text = data.draw(st.sampled_from(ends)).join(mixed)
    found = read(tmp_path, "mixed.obj", text.encode())
    assert np.array_equal(shown(found), shown(meant))


@pytest.mark.parametrize(
    ("faces", "said"),
    [
        ("f 0 1 2", "line 4: vertex 0: indices of an OBJ begin at 1"),
        ("f 1 2 \\\n 0", "line 4: vertex 0: indices of an OBJ begin at 1"),
        ("f 1 2 3\nf -1 -2 -4", "line 5: vertex -4: there are 3 before it"),
        ("f -1 -2 x", "line 4: f -1 -2 x: is no face"),
    ],
)
def test_an_invalid_index_is_reported_with_its_line(tmp_path: Path, faces: str, said: str) -> None:
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}\n"
    with pytest.raises(InputError, match=re.escape(f"bad.obj: {said}")):
        read(tmp_path, "bad.obj", text.encode())


@pytest.mark.parametrize("faces", ["", "element face 1\nproperty list uchar int vertex_indices\n"])
def test_strips_of_triangles_are_read(tmp_path: Path, faces: str) -> None:
    header = (
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
        f"property float z\n{faces}element tristrips 1\n"
        "property list int int vertex_indices\nend_header\n"
    )
    rows = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n"
    rows += ("3 2 3 4\n" if faces else "") + "8 0 1 2 3 -1 3 5 4\n"
    mesh = read(tmp_path, "strips.ply", (header + rows).encode())
    assert area_vectors(mesh)[:, 2].tolist() == [0.5] * (4 if faces else 3)


L_CORNERS = ["0 0 0", "2 0 0", "2 1 0", "1 1 0", "1 2 0", "0 2 0"]


def l_shape(kind: str) -> str:
    match kind:
        case "obj":
            return "\n".join([*(f"v {c}" for c in L_CORNERS), "f 1 2 3 4 5 6", ""])
        case "off":
            return "\n".join(["OFF", "6 1 0", *L_CORNERS, "6 0 1 2 3 4 5", ""])
        case _:
            loop = [f"vertex {c}" for c in L_CORNERS]
            lines = ["solid l", "facet normal 0 0 1", "outer loop", *loop, "endloop", "endfacet"]
            return "\n".join([*lines, "endsolid l", ""])


@pytest.mark.parametrize("kind", ["obj", "off", "stl"])
@pytest.mark.parametrize(("encoding", "end"), [("utf-16", "\n"), ("utf-8-sig", "\r")])
def test_encodings_and_line_ends_do_not_matter(
    tmp_path: Path, kind: str, encoding: str, end: str
) -> None:
    content = l_shape(kind).replace("\n", end).encode(encoding)
    mesh = read(tmp_path, f"l.{kind}", content)
    assert area(mesh) == pytest.approx(3.0)
    assert len(mesh.triangles) == 4
    assert mesh.vertices.max() == 2.0


@pytest.mark.parametrize(
    "text",
    [
        "OFF6 1 0\n{}\n6 0 1 2 3 4 5\n",
        "OFF 6 1 0\n{}\n6 0 1 2 3 4 5",
        "6 1 0\n{}\n6 0 1 2 3 4 5\n",
        "# of ours\nOFF # here\n\n6 1 # two\n{}\n\n6 0 1 2 3 4 5 # end\n# end\n",
        "OFF\n6 1 0\n{}\n6 0 1 2 3 4 5 255 0 0\n",
        "OFF\n6 1 0\n{}\n6  0 1 2 3 4 5  0.5 0.5 0.5 1\n",
        "COFF\n6 1 0\n{} 255 0 0 255\n6 0 1 2 3 4 5\n",
        "NOFF\n6 1 0\n{} 0 0 1\n6 0 1 2 3 4 5\n",
        "STCNOFF\n6 1 0\n{} 0 0 1 1 0 0 1 0.5 0.5\n6 0 1 2 3 4 5\n",
    ],
)
def test_variants_of_off(tmp_path: Path, text: str) -> None:
    before, between = text.split("{}")
    more, _, after = between.partition("\n")
    content = before + "\n".join(corner + more for corner in L_CORNERS) + "\n" + after
    assert area(read(tmp_path, "l.off", content.encode())) == pytest.approx(3.0)


def test_an_off_with_other_lines_than_rows(tmp_path: Path) -> None:
    content = f"OFF\n6 2 0\n{'  '.join(L_CORNERS)} 4 0 1 2 3 4 0\n3 4 5".encode()
    assert area(read(tmp_path, "l.off", content)) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("OFF\n6 1 0\n{}\n", "truncated"),
        ("OFF\n6 1 0\n{}\n6 0 1 2 3", "line 9: .* is no face"),
        ("OFF\n5 1 0\n{}\n6 0 1 2 3 4 5\n", "line 9: 1 more rows"),
        ("OFF\n6 1 0\n{}\n3 0 1 2\n3 0 2 3\n", "line 10: 1 more rows .* inconsistent"),
        ("OFF\n6 1 0\n{}\n6 0 1 2 3 4 6\n", "line 9: .* beyond 0 to 5"),
        ("4OFF\n6 1 0\n{}\n6 0 1 2 3 4 5\n", "four or more dimensions"),
        ("OFF BINARY\n6 1 0\n{}\n6 0 1 2 3 4 5\n", "binary OFF"),
        ("COFFEE\n6 1 0\n{}\n6 0 1 2 3 4 5\n", "no OFF header"),
    ],
)
def test_an_off_that_does_not_fit_its_counts(tmp_path: Path, text: str, said: str) -> None:
    content = text.format("\n".join(L_CORNERS)).encode()
    with pytest.raises(InputError, match=said):
        read(tmp_path, "l.off", content)


def test_trailing_comments_and_colours_of_an_obj(tmp_path: Path) -> None:
    lines = [f"v {c} 1.0 0.5 0.5 # {k}" if k % 2 else f"v {c}# no" for k, c in enumerate(L_CORNERS)]
    content = "\n".join([*lines, "f 1/1/1 2//2 3 4 \\ \n 5 6 # all", "# 7 8"])
    assert area(read(tmp_path, "l.obj", content.encode())) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("v 0,5 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3", "line 1: 0,5 0 0: has decimal commas"),
        ("v 0 0 0\nv 1, 0, 0\nv 1 1 0\nf 1 2 3", "line 2: .* commas between numbers"),
        ("v 0 0 0\nv 1 0\nv 1 1 0\nf 1 2 3", "line 2: 1 0: is no vertex"),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4", "line 4: vertex 4: there are 3"),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 3 2", "ends within a face; it is truncated"),
        ("v 0 0 0\ncurv 0 1 1 2\n", "free-form surfaces"),
        ("a letter\n", "neither vertices nor faces"),
    ],
)
def test_an_obj_that_is_none_is_named(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(tmp_path, "bad.obj", text.encode())


@pytest.mark.parametrize("solids", [1, 3])
def test_a_text_stl_cut_anywhere_in_its_last_solid_is_truncated(
    tmp_path: Path, solids: int
) -> None:
    text = "\n".join([l_shape("stl").strip()] * solids)
    start = text.rfind("solid l\nfacet") + len("solid l\nfa")
    assert area(read(tmp_path, "l.stl", text.encode())) == pytest.approx(3 * solids)
    for end in range(start, text.rfind("endsolid") + len("endsoli")):
        with pytest.raises(InputError, match="truncated"):
            read(tmp_path, "cut.stl", text[:end].encode())


def test_a_text_stl_may_have_any_case_and_lines(tmp_path: Path) -> None:
    for text in (
        l_shape("stl").upper(),
        l_shape("stl").replace("\n", " ").replace("solid l ", "solid l\n", 1),
        l_shape("stl").replace("\n", "\n\n\t"),
        l_shape("stl") + "comments after data\n",
    ):
        mesh = read(tmp_path, "l.stl", text.encode())
        assert area(mesh) == pytest.approx(3.0)


@pytest.mark.parametrize("more", [b"\xff" * 7, b"\0" * 4096])
def test_a_binary_stl_may_begin_with_solid_and_have_bytes_after_it(
    tmp_path: Path, more: bytes
) -> None:
    content = b"solid f\xfcr".ljust(80, b"\0") + bytes(stl.export_stl(block()))[80:] + more
    assert len(read(tmp_path, "block.stl", content).triangles) == 12


@pytest.mark.parametrize("count", [0, 11, 13])
def test_a_binary_stl_with_another_count_is_refused(tmp_path: Path, count: int) -> None:
    content = bytes(stl.export_stl(block()))
    content = content[:80] + count.to_bytes(4, "little") + content[84:]
    with pytest.raises(InputError, match=r"counts (0|11) triangles|claims 13"):
        read(tmp_path, "block.stl", content)


def test_a_page_that_is_saved_as_a_mesh_is_no_truncated_one(tmp_path: Path) -> None:
    page = b"<!DOCTYPE html>\n<html><head><title>Sign in</title></head></html>\n" * 9
    for kind in ("stl", "ply", "off", "obj", "glb", "gltf", "dae"):
        with pytest.raises(InputError) as refused:
            read(tmp_path, f"page.{kind}", page)
        assert "truncated" not in str(refused.value)


def test_an_obj_that_ends_before_its_last_faces_warns(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    lines = groups(3, relative=False).splitlines(keepends=True)
    last = max(i for i, line in enumerate(lines) if line.startswith(b"v "))
    path.write_bytes(b"".join(lines[: last + 1]))
    (line,) = read_mesh(path).warnings
    assert "cut off" in line
    path.write_bytes(b"".join(lines))
    assert read_mesh(path).warnings == ()
    path.write_bytes(b"".join(lines[: last + 1]) + b"l -1 -2 -3 -4\n")  # drawn as lines
    assert read_mesh(path).warnings == ()
