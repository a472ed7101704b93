"""The page of a run shows all that was found, by itself, whatever names say."""

import base64
import hashlib
import html
import json
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
import pytest
import trimesh
from playwright.sync_api import Page, sync_playwright
from scipy.spatial.transform import Rotation

import facetlog
from facetlog.kb.explaining.unseen import Unseen
from facetlog.kb.recognize import judge_loaded_scene
from facetlog.page.contents import Answers, Subject, contents
from facetlog.page.uncertainty import add_ellipsoids
from facetlog.page.write import page
from facetlog.perception.facts.pieces.piece_facts import shown_pieces
from facetlog.perception.pieces.shown_pieces import ShownPieces
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.scene import Scene, Vertex
from facetlog.perception.space.space import Space
from facetlog.perception.space.space import State as SpaceState
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.pipeline import Recognised, facts_of, load_scene, open_models
from facetlog.verdicts_schema import VerdictsRecord

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
MOST_BYTES = 8_000_000
PATIENCE = 120.0  # seconds that a browser has on a machine with much else to do


def _view(name: str, scene: Scene, azimuth_deg: float) -> View:
    """A picture of nothing, from where the scene would fill a third of it."""
    around = np.deg2rad(azimuth_deg)
    middle = scene.points.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    centre = middle + 2.5 * size * np.array([np.cos(around), np.sin(around), 0.6])
    forward = (middle - centre) / np.linalg.norm(middle - centre)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.column_stack([right, np.cross(forward, right), forward])
    noise = np.random.default_rng(0).integers(0, 255, (480, 640), dtype=np.uint8)
    return View(name, noise, Camera(640, 480, 700, 700, 319.5, 239.5), Pose(rotation, centre))


def _run(scene: Scene, *names: str, near: bool = False) -> Recognised:
    views = tuple(_view(name, scene, 60.0 * k) for k, name in enumerate(names))
    scene = replace(scene, views=names)
    with open_models() as base:
        load_scene(base, scene)
        recognition = judge_loaded_scene(base, scene.name, near=near)
    return Recognised(ViewSet(scene.name, views), scene, facts_of(scene), recognition)


def _subject(found: Recognised) -> Subject:
    return Subject.of_run(found, shown_pieces(found.scene))


@pytest.fixture(scope="module")
def table() -> Recognised:
    return _run(build("table", {}), "a.png", "b.png")


@pytest.fixture(scope="module")
def text(table: Recognised) -> str:
    return page(_subject(table))


def test_every_verdict_and_every_condition_is_there(table: Recognised) -> None:
    shown = contents(_subject(table))
    verdicts = table.recognition.verdicts
    assert [v["summary"] for v in shown["best"]] == [v.summary for v in table.recognition.best]
    assert len(shown["best"]) + len(shown["others"]) == len(verdicts)
    labels = [c["label"] for v in (*shown["best"], *shown["others"]) for c in v["conditions"]]
    assert sorted(labels) == sorted(c.label for v in verdicts for c in v.conditions)
    assert {v["state"] for v in shown["best"]} == {"holds"}
    assert shown["answer"].startswith("t1 is a table")
    (origin,) = (line["text"] for line in shown["best"][0]["lines"] if "confidence" in str(line))
    assert table.recognition.best[0].confidence.origin in str(origin)


def test_what_comes_nearest_to_a_set_is_said_in_page_and_data() -> None:
    found = _run(build("bench", {}), near=True)
    lacking = {
        (v.model, c.label) for v in found.recognition.verdicts for c in v.conditions if c.nearest
    }
    assert lacking
    said = {
        (v.model, c["label"])
        for v, shown in zip(
            [v for v in found.recognition.verdicts if v not in found.recognition.best],
            contents(_subject(found))["others"],
            strict=True,
        )
        for c in shown["conditions"]
        if any(step["text"].startswith("nearest") for step in c["steps"])
    }
    assert said == lacking
    data = {**found.recognition.to_json(), "problems": [], "warnings": []}
    VerdictsRecord.model_validate_json(json.dumps(data), strict=True)


def test_pictures_have_the_faces_that_they_show_and_no_others(table: Recognised) -> None:
    first, second = contents(_subject(table))["pictures"]
    data = np.frombuffer(base64.b64decode(first["data"]), dtype=np.uint8)
    decoded = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    assert decoded is not None
    assert decoded.shape == (first["height"], first["width"])
    names = {outline.name for outline in first["outlines"]}
    assert 3 <= len(names) < len(table.scene.faces)
    for outline in first["outlines"]:
        points = _corners(outline.path)
        assert ((points > 0) & (points < (first["width"], first["height"]))).all()
    assert names != {outline.name for outline in second["outlines"]}


def _corners(path: str) -> FloatArray:
    found = [xy.split(",") for xy in re.findall(r"[\d.-]+,[\d.-]+", path)]
    return np.array(found, dtype=np.float64)


def test_edges_that_bound_no_face_can_be_lit_up_everywhere(table: Recognised) -> None:
    whole = table.scene
    legless = replace(whole, faces=whole.faces[:2], bodies=())
    rings = [edge for face in legless.faces for edge in face.outline]
    loose = [k for k, e in enumerate(whole.edges, 1) if not {e.start, e.end} & {*rings}]
    assert loose
    shown = contents(replace(_subject(table), scene=legless, pieces=ShownPieces((), ())))
    assert ("e", "edges without a face", True) in shown["kinds"]
    assert {f"e{k}" for k in loose} <= _nodes(shown["model_view"])
    drawn = {outline.name for outline in shown["pictures"][0]["outlines"]}
    assert drawn & {f"e{k}" for k in loose}
    assert not [n for n in _nodes(contents(_subject(table))["model_view"]) if n.startswith("e")]


def test_an_ellipsoid_is_two_standard_deviations_along_each_of_its_axes() -> None:
    turn = Rotation.from_euler("xyz", [0.3, -0.8, 1.1]).as_matrix()
    sds = np.array([0.1, 0.2, 0.4])
    vertices = (
        Vertex(np.array([0.0, 0.0, 0.0]), turn @ np.diag(sds**2) @ turn.T),
        Vertex(np.array([3.0, 4.0, 0.0]), np.diag([0.01, 0.0, 0.0])),
        Vertex(np.array([1.0, 0.0, 0.0]), np.full((3, 3), np.inf)),
    )
    graph = trimesh.Scene()
    add_ellipsoids(graph, Scene("sure", vertices=vertices))
    assert set(graph.graph.nodes_geometry) == {"v1", "v2"}
    matrix, _ = graph.graph["v1"]
    assert np.linalg.det(matrix) > 0.0
    half_axes = np.linalg.norm(matrix[:3, :3], axis=0)
    assert half_axes == pytest.approx(2.0 * sds)
    assert np.abs(turn.T @ matrix[:3, :3] / half_axes).round(6).tolist() == np.eye(3).tolist()
    flat, _ = graph.graph["v2"]
    assert np.linalg.norm(flat[:3, :3], axis=0).min() > 0.0  # a viewer cannot turn a sheet


def test_what_was_not_seen_is_lit_where_it_would_be(table: Recognised) -> None:
    found = table.recognition.verdicts
    box = next(v for v in found if v.model == "box")
    said = (
        Unseen("no view looks at it from above", "look at it from there", (0.0, 0.0, 1.0)),
        Unseen("there is space that nobody looked into", "look there", (1.0, 0.0, 0.0), space=True),
        Unseen("too few views"),
    )
    subject = Subject(table.scene, _unseen_round(table.scene), others=(replace(box, unseen=said),))
    shown = contents(subject)
    (verdict,) = shown["others"]
    lines = [(line["text"], line["names"]) for line in verdict["unseen"]]
    assert lines == [
        ("unseen: no view looks at it from above; look at it from there", ""),
        ("unseen: there is space that nobody looked into; look there", "unseen1"),
        ("unseen: too few views", ""),
    ]
    assert {"unseen1"} <= _nodes(shown["model_view"])


def _unseen_round(scene: Scene) -> ShownPieces:
    """As if nobody had seen anything of the space round the one thing of a scene."""
    (space,) = shown_pieces(scene).spaces
    cells = np.full_like(space.cells, SpaceState.UNSEEN)
    return ShownPieces((), (Space(space.lattice, cells, closed=False),), ("t1",))


def _nodes(model_view: str) -> set[str]:
    (data,) = re.findall(r'base64_data="([A-Za-z0-9+/=]+)"', model_view)
    glb = base64.b64decode(data)
    size = int.from_bytes(glb[12:16], "little")
    return {node.get("name", "") for node in json.loads(glb[20 : 20 + size])["nodes"]}


def test_answers_are_a_table_whose_names_light_up(table: Recognised) -> None:
    answers = Answers("face(F)", ("F", "A (cm²)"), (("f1", "12.5"), ("f2", "<b>")))
    subject = Subject(table.scene, shown_pieces(table.scene), answers=answers)
    text = page(subject)
    assert "<h1>face(F)</h1>" in text
    assert '<th scope="col">A (cm²)</th>' in text
    assert '<button type="button" class="line" data-names="f2">f2</button>' in text
    assert "<b>" not in text[text.index("<tbody>") :]
    assert "What it is" not in text


def test_only_names_that_the_scene_has_light_up(table: Recognised) -> None:
    cells = ("f1 and f99", "e7000–e7010", "p400", "v3–v5", "v39–v42")
    answers = Answers("face(F)", ("F",), tuple((cell,) for cell in cells))
    shown = contents(Subject(table.scene, shown_pieces(table.scene), answers=answers))
    names = [cell["names"] for (cell,) in shown["answers"]["rows"]]
    assert names == ["f1", "", "", "v3 v4 v5", "v39 v40"]
    assert [cell["text"] for (cell,) in shown["answers"]["rows"]] == [*cells]


def test_no_script_runs_but_those_of_the_page_and_its_frame(text: str) -> None:
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    (allowed,) = re.findall(r"script-src ([^;]*)", policy)
    (inside,) = re.findall(r'srcdoc="([^"]*)"', text)
    scripts = re.findall(r"<script>(.*?)</script>", text + html.unescape(inside), re.DOTALL)
    digests = [base64.b64encode(hashlib.sha256(one.encode()).digest()).decode() for one in scripts]
    assert allowed.split() == [f"'sha256-{digest}'" for digest in digests]
    assert "default-src 'none'" in policy


@pytest.mark.parametrize(
    "template", [*Path(facetlog.__file__).parent.rglob("*.html.jinja")], ids=lambda path: path.stem
)
def test_every_kind_of_page_begins_with_its_policy(template: Path) -> None:
    text = template.read_text(encoding="utf-8")
    assert text.index("<meta charset") < text.index("{{ head | safe }}") < text.index("<title>")


def test_names_are_text_and_not_markup() -> None:
    hostile = replace(build("cuboid", {}), name="<script>alert(1)</script>")
    found = page(_subject(_run(hostile, '"><img src=x onerror=alert(1)>')))
    assert "<script>alert" not in found
    assert "<img" not in found


def test_a_scene_without_faces_has_a_page_too() -> None:
    empty = Scene("nothing", (), (), (), ())
    found = page(_subject(_run(empty)))
    assert "no model matches" in found
    assert "<iframe" not in found
    assert "<figure" not in found


SOFTWARE_3D = ("--use-gl=swiftshader", "--enable-unsafe-swiftshader")


@contextmanager
def _browser_page(*graphics: str, **options: Any) -> Iterator[Page]:
    """Open an empty page in a browser."""
    arguments = ["--no-sandbox", *(graphics or SOFTWARE_3D)]
    with sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=BROWSER, args=arguments)
        shown = browser.new_page(**options)
        shown.set_default_timeout(1000 * PATIENCE)
        yield shown
        browser.close()


def _address(text: str, folder: Path) -> str:
    path = folder / "page.html"
    path.write_text(text, encoding="utf-8")
    return path.as_uri()


def _content(text: str, folder: Path, until: str, *graphics: str, scheme: str = "light") -> str:
    """Return the text of a page in a browser once JavaScript says that it is so far."""
    # Tests put scripts into the page.
    with _browser_page(*graphics, color_scheme=scheme, bypass_csp=True) as shown:
        shown.goto(_address(text, folder))
        shown.wait_for_function(until)
        return shown.content()


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs chromium")
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", ["run", "answers"])
def test_nothing_serious_keeps_anybody_from_reading_the_page(
    text: str, table: Recognised, kind: str, scheme: Literal["light", "dark"], tmp_path: Path
) -> None:
    if kind == "answers":
        answers = Answers("face(F)", ("F", "A (cm²)"), (("f1", "12.5"), ("f2", "3.0")))
        text = page(Subject(table.scene, shown_pieces(table.scene), answers=answers))
    rules = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    check = """
      document.querySelectorAll("details").forEach((one) => { one.open = true; });
      axe.run(document, { iframes: false }).then((found) => {
        const wrong = found.violations.map((one) =>
          `${one.impact}: ${one.id} ${one.nodes[0].html} ${one.nodes[0].failureSummary}`);
        const said = document.createElement("pre");
        said.id = "axe";
        said.textContent = [`${found.passes.length} passes`, ...wrong].join("\\n");
        document.body.append(said);
      });"""
    checked = text.replace(
        "</body>\n</html>", f"<script>{rules}</script><script>{check}</script></html>"
    )
    shown = _content(checked, tmp_path, "document.querySelector('#axe')", scheme=scheme)
    (said,) = re.findall(r'<pre id="axe">(.*?)</pre>', shown, re.DOTALL)
    passes, *wrong = said.splitlines()
    assert int(passes.split()[0]) > 10
    assert not [line for line in wrong if line.startswith(("serious", "critical"))], said


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs chromium")
def test_a_page_obeys_its_policy_works_and_is_no_wider_than_its_window(
    table: Recognised, tmp_path: Path
) -> None:
    long = replace(table.scene, name="n" * 10_000, warnings=("w" * 10_000,))
    with _browser_page() as shown:
        refused: list[str] = []
        shown.on("console", lambda message: refused.append(message.text))
        shown.goto(_address(page(_subject(replace(table, scene=long))), tmp_path))
        seen = "() => document.querySelector('.name')"
        shown.frames[1].wait_for_function(seen)
        shown.click(".line")
        assert (shown.text_content("#lit") or "").startswith("Lit: f")
        assert shown.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert not [text for text in refused if "Content Security Policy" in text]
        put_in = "document.body.append(Object.assign(document.createElement('script'), %s))"
        shown.evaluate(put_in % "{textContent: 'window.strange = 1'}")
        assert shown.evaluate("window.strange === undefined")


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs chromium")
def test_names_and_ellipsoids_are_there_for_what_is_shown_and_is_not_hidden(
    table: Recognised, text: str, tmp_path: Path
) -> None:
    with _browser_page() as shown:
        shown.goto(_address(text, tmp_path))
        view = shown.frames[1]

        def names_when(condition: str) -> set[str]:
            some = (
                "() => { const names = [...document.querySelectorAll('.name')].filter((one) =>"
                " one.style.visibility === 'visible').map((one) => one.textContent);"
                f" return ({condition}) && names; }}"
            )
            found = view.wait_for_function(some)
            return set(found.json_value())

        faces = names_when("names.length > 0")
        assert {name[0] for name in faces} == {"f"}
        assert len(faces) < len(table.scene.faces)  # the others are behind these
        shown.uncheck(".kind[value=f]")
        shown.check(".kind[value=p]")
        names_when("names.includes('p1') && !names.some((name) => name[0] === 'f')")
        shown.click(".line")
        lit = (shown.get_attribute(".line", "data-names") or "").split()
        assert names_when("names.some((name) => name[0] === 'f')") <= {*lit}
        is_sure = "() => scene.getObjectByName('v1').visible"
        assert not view.evaluate(is_sure)
        shown.check(".kind[value=v]")
        view.wait_for_function(is_sure)
        view.evaluate("() => parent.postMessage({ picked: 'v1' }, '*')")  # as a click on it does
        names_when("names.join() === 'v1'")


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs chromium")
def test_a_browser_that_has_no_webgl_is_told_so(text: str, tmp_path: Path) -> None:
    until = "document.querySelector('#without-3d')"
    shown = _content(text, tmp_path, until, "--disable-3d-apis")
    assert "<iframe" not in shown
    assert "it has no WebGL" in shown


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs chromium")
def test_a_page_that_listens_only_after_its_3d_view_spoke_asks_it_again(
    text: str, tmp_path: Path
) -> None:
    body, script = text.rsplit("<script>", 1)
    # From the head on, for the view may speak before its page is read to the end.
    late = """<script>
      const read = new Promise((go) => addEventListener("DOMContentLoaded", go));
      const spoke = new Promise((go) => addEventListener("message", go, { once: true }));
      Promise.all([read, spoke]).then(() => {
        const script = document.createElement("script");
        script.textContent = document.querySelector("#late").textContent;
        document.body.append(script);
      });
    </script>"""
    text = body.replace("<head>", "<head>" + late, 1)
    text += '<script type="text/plain" id="late">' + script
    until = "document.querySelector('#without-3d')"
    assert "it has no WebGL" in _content(text, tmp_path, until, "--disable-3d-apis")
