"""Five lines of Python: recognise, read, classify and ask, and what comes back."""

import html
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import facetlog
from facetlog.errors import InputError
from facetlog.library import result
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.mesh_export import write_mesh
from facetlog.perception.surfaces.scene_file import write_scene
from facetlog.perception.types import Camera, Pose, View
from tests.perception.reading.mat.mat_photos import photos, write_photos
from tests.rendered import tour

NOTHING = """
model nothing
  "A thing that is not there."
  face f
  small: area(f) at most 1 mm * 1 mm
"""


@pytest.fixture(scope="module")
def table():
    return facetlog.recognize(build("table", {}))


@pytest.mark.slow
def test_a_scene_is_recognised_with_reasons(table):
    assert [verdict.model for verdict in table.best] == ["table"]
    assert repr(table).startswith("<table: t1 is a table (")
    why = table.why("table")
    assert why.holds
    assert str(why).startswith("t1 is a table")
    assert "parts: top = f" in str(why)
    not_chair = table.why_not("chair", count=1)
    assert not not_chair.holds
    assert len(not_chair.verdicts) == 1
    assert "no chair" in str(not_chair)
    assert table.to_dict()["schema"] == "facetlog-verdicts/2"
    assert why.to_dict()[0]["model"] == "table"


def test_a_notebook_shows_the_page_with_proofs_and_the_scene_to_turn(table):
    shown = table._repr_html_()
    assert shown.startswith('<iframe sandbox="allow-scripts" srcdoc=')
    assert "<script" not in shown
    inside = html.unescape(shown[shown.index('srcdoc="') + 8 : shown.rindex('" title=')])
    assert "<h1>t1 is a table (" in inside
    assert 'class="line" data-names="f' in inside
    assert table.why("table")._repr_html_().startswith("<pre>t1 is a table")


def test_a_page_is_written_with_the_pictures_that_there_are(table, tmp_path, monkeypatch):
    path = tmp_path / "table.html"
    camera, pose = Camera(64, 48, 70, 70, 31.5, 23.5), Pose(np.eye(3), np.array([0.5, 0.5, -3]))
    views = tuple(View(n, np.zeros((48, 64), dtype=np.uint8), camera, pose) for n in "ab")
    seen = ViewSet("table", views)
    found = facetlog.Result(table.scene, table.recognition, _view_set=seen)
    found.write_page(path)
    text = path.read_text(encoding="utf-8")
    assert text.count("<figure>") == len(views)
    assert html.unescape(found._repr_html_()).count("<figure>") == len(views)
    monkeypatch.setattr(result, "MOST_PAGE_BYTES", len(text.encode()) - 1)
    shown = html.unescape(found._repr_html_())  # pictures are left out first
    assert "<h1>t1 is a table (" in shown
    assert "<figure>" not in shown


def test_a_name_in_a_notebook_is_text_and_not_markup(tmp_path):
    path = tmp_path / "<img src=x>.json"
    write_scene(build("cuboid", {}), path)
    shown = facetlog.recognize(path)._repr_html_()
    assert "<img" not in shown


def test_a_result_goes_through_a_file_and_is_asked_again(table):
    table.why("table")  # which opens a knowledge base
    copy = pickle.loads(pickle.dumps(table))  # noqa: S301 - its own
    assert copy.why("table").holds
    assert repr(copy) == repr(table)
    copy.close()


@pytest.mark.parametrize("source", [None, 5, [], ["a.png"], [build("cuboid", {})]])
def test_what_is_no_source_is_refused_in_a_line(source):
    with pytest.raises(InputError, match=r"^[^\n]*(give the folder|2 are needed)[^\n]*$"):
        facetlog.recognize(source)


@pytest.mark.slow
def test_what_is_doubtful_of_the_views_is_a_warning_of_the_result(monkeypatch):
    block = replace(build("cuboid", {}), warnings=("up is that of the ground",))
    views = ViewSet("views", tuple(tour("block")), problems=("a.png is cut off; left out",))
    monkeypatch.setattr("facetlog.pipeline.read_views_from", lambda *_, **__: views)
    monkeypatch.setattr("facetlog.pipeline.reconstruct_views", lambda *_, **__: block)
    monkeypatch.setattr("facetlog.perception.reading.pose_files.register.has_poses", lambda _: True)
    assert facetlog.recognize(".").warnings == (
        "a.png is cut off; left out",
        "up is that of the ground",
    )


def test_meshes_are_read_with_up_and_unit(tmp_path):
    path = tmp_path / "block.ply"
    trimesh.creation.box((300.0, 200.0, 100.0)).export(path)
    scene = facetlog.read_scene(path, up="y", unit="mm")
    assert scene.metric
    assert scene.up is not None
    assert scene.up.tolist() == [0.0, 1.0, 0.0]
    assert np.ptp(scene.points, axis=0) == pytest.approx([0.3, 0.2, 0.1])
    leaning = facetlog.recognize(path, up=(0.0, 2.0, 2.0)).scene.up
    assert leaning == pytest.approx([0.0, 0.5**0.5, 0.5**0.5])
    assert facetlog.recognize(path).best[0].model == "box"


def test_up_and_unit_are_those_of_the_command_line_or_a_vector(tmp_path):
    path = tmp_path / "block.glb"  # whose format states which way is up
    write_mesh(build("table", {}), path)
    assert facetlog.read_scene(path).up is not None
    assert facetlog.read_scene(path, up="auto").up is not None
    assert facetlog.read_scene(path, up="none").up is None
    block = build("cuboid", {})
    assert facetlog.recognize(block, up="auto").scene.up is not None
    assert facetlog.recognize(block, up="none").scene.up is None
    for up in ("upwards", (0.0, 0.0, 0.0), (0.0, 1.0), ["a", 0, 1]):
        with pytest.raises(InputError, match="up "):
            facetlog.read_scene(path, up=up)
    with pytest.raises(InputError, match="use one of m, "):
        facetlog.read_scene(path, unit="foot")


def test_a_square_is_that_of_the_command_line_and_of_a_mat_alone(tmp_path, monkeypatch):
    block = build("cuboid", {})
    write_scene(block, tmp_path / "block.json")
    with pytest.raises(InputError, match=r"square is for pictures of a mat, and .*block\.json"):
        facetlog.recognize(tmp_path / "block.json", square="17.6mm")
    with pytest.raises(InputError, match=r"square '17\.6': give a length above 0 with its unit"):
        facetlog.recognize(tmp_path, square="17.6")
    read: list[ViewSet] = []

    def reconstructed(views: ViewSet, **_: object) -> Scene:
        read.append(views)
        return block

    monkeypatch.setattr("facetlog.pipeline.reconstruct_views", reconstructed)
    folder = write_photos(tmp_path / "photos", photos(2))
    for square in ("36mm", "1.8 cm"):
        facetlog.recognize(folder, square=square)
    far, near = (np.array([view.pose.centre for view in found.views]) for found in read)
    assert far == pytest.approx(2.0 * near, rel=1e-3)


def test_options_count_for_scenes_and_their_files(tmp_path):
    path = tmp_path / "block.json"
    block = replace(build("cuboid", {}), metric=False)
    write_scene(block, path)
    for source in (path, block):
        found = facetlog.recognize(source, up="x", unit="cm").scene
        assert (found.up is not None, found.metric) == (True, True)
        np.testing.assert_array_equal(found.up, [1.0, 0.0, 0.0])
        np.testing.assert_allclose(found.points, block.points / 100)
    assert facetlog.read_scene(path, up="none").up is None
    scaled = facetlog.recognize(path, scale="height = 74 cm").scene
    assert np.ptp(scaled.points[:, 2]) == pytest.approx(0.74)
    with pytest.raises(InputError, match="metres already"):
        facetlog.recognize(build("cuboid", {}), unit="cm")


def test_own_models_are_asked_with_the_others(tmp_path):
    path = tmp_path / "nothing.model"
    path.write_text(NOTHING, encoding="utf-8")
    found = facetlog.recognize(build("cuboid", {}), models=path)
    assert {verdict.model for verdict in found.verdicts} >= {"nothing", "box"}
    assert "fails" in str(found)
    assert not found.why("nothing").holds


@pytest.mark.slow
def test_views_are_recognised_from_their_folder_and_one_by_one(tmp_path):
    views = tour("block")
    found = facetlog.recognize(iter(views), up="z")
    assert [verdict.model for verdict in found.best] == ["box"]
    assert found.scene.views == tuple(view.name for view in views)
    found.write_page(tmp_path / "block.html")
    assert (tmp_path / "block.html").read_text(encoding="utf-8").count("<figure>") == len(views)
    asked = facetlog.ask(list(views), "face(F)", up="z")
    assert list(asked["F"]) == [f"f{i}" for i in range(1, len(found.scene.faces) + 1)]


def test_what_is_not_there_is_said_before_any_work(tmp_path):
    with pytest.raises(InputError, match="there is no such file or folder"):
        facetlog.recognize(tmp_path / "views")
    with pytest.raises(InputError, match="views does not exist"):
        facetlog.read_scene(tmp_path / "views")
    with pytest.raises(InputError, match="does not exist"):
        facetlog.recognize(build("cuboid", {}), models="gone.model")


def test_scenes_are_asked_into_a_table():
    chair, block = build("chair", {}), build("cuboid", {})
    faces = facetlog.ask([chair, block, block], "face(F), upward(F), area(F, A, _)")
    assert list(faces.columns) == ["Scene", "F", "A"]
    assert faces["A"].dtype == np.float64
    assert set(faces["Scene"]) == {"chair", "cuboid", "cuboid 2"}
    one = facetlog.ask(block, "face(F)", most=2)
    assert one.to_dict("list") == {"F": ["f1", "f2"]}
    assert list(facetlog.ask(block, "face(F), area(F, A, _), A > 100").columns) == ["F", "A"]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("notes.md", r"has no poses, only notes\.md: add pictures of a thing on a printed"),
        ("images.bin", r"part of a COLMAP model: cameras\.bin is missing beside images\.bin"),
    ],
)
def test_a_folder_without_poses_says_what_it_needs(tmp_path, name, says):
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=says):
        facetlog.recognize(tmp_path)


def test_files_are_classified_into_a_table(tmp_path):
    write_scene(build("chair", {}), tmp_path / "a.json")
    write_scene(build("cuboid", {}), tmp_path / "b.json")
    (tmp_path / "c.json").write_text("{", encoding="utf-8")
    rows = facetlog.classify([tmp_path / f"{name}.json" for name in "abc"], workers=1)
    assert list(rows["model"])[:2] == ["chair", "box"]
    assert rows["error"].isna().tolist() == [True, True, False]


def test_exports_are_loaded_only_when_they_are_named():
    code = (
        "import sys, facetlog; "
        "assert not {'numpy', 'facetlog.library'} & set(sys.modules), 'loaded at once'; "
        "assert set(facetlog.__all__) <= set(dir(facetlog)); facetlog.recognize; "
        "assert not hasattr(facetlog, 'recognise_all')"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
