"""Report a run's results as text, as JSON, and as a folder of files and pictures."""

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from facetlog import __version__
from facetlog.degree_plot import write_degree_plot
from facetlog.kb.explaining.verdict_text import NO_MODEL, format_holding
from facetlog.output_folder import output_folder
from facetlog.pipeline import Progress, Recognised
from facetlog.plurals import many
from facetlog.terminal import fit_on_one_line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from facetlog.degree_plot import Degrees
    from facetlog.perception.pieces.shown_pieces import ShownPieces
    from facetlog.perception.step_clock import StepClock
    from facetlog.perception.surfaces.drawing.lettering import ColourImage

__all__ = ["format_verdicts_json", "format_verdicts_text", "laid_out", "write_report"]

SHEET_FILE = "contact-sheet.png"
PIECES_SHEET_FILE = "pieces-sheet.png"
DEGREE_FILE = "degrees.svg"
# Pictures wait for the sheet at this width: in full size a hundred large ones fill the memory.
SHEET_PICTURE_PX = 800
# Of numbers that are not asked for in full: finer than anything is measured.
DIGITS = 6
# Members of the object, its verdicts, their members, and conditions stand on lines of their own.
LEVELS = 4


def format_verdicts_json(found: Recognised, *, full: bool = False) -> str:
    """Format all verdicts with the reasons for them as one JSON object with `schema` inside.

    A condition takes a line, and numbers have six digits; with `full` each condition has its whole
    proof, a value a line.
    """
    notes = {"problems": list(found.view_set.problems), "warnings": list(found.scene.warnings)}
    data = {**found.recognition.to_json(full=full), **notes}
    return json.dumps(data, indent=1) if full else laid_out(_round_numbers(data), LEVELS)


def _round_numbers(data: Any) -> Any:
    if isinstance(data, float):
        return float(f"{data:.{DIGITS}g}")
    if isinstance(data, dict):
        return {key: _round_numbers(value) for key, value in data.items()}
    return [_round_numbers(value) for value in data] if isinstance(data, list | tuple) else data


def laid_out(data: object, levels: int) -> str:
    """Format data as JSON, one member a line down to so many levels."""
    if not levels or not data or not isinstance(data, dict | list):
        return json.dumps(data)
    if isinstance(data, list):
        members, ends = (laid_out(item, levels - 1) for item in data), "[]"
    else:
        members = (f"{json.dumps(k)}: {laid_out(x, levels - 1)}" for k, x in data.items())
        ends = "{}"
    return f"{ends[0]}\n" + ",\n".join(members) + f"\n{ends[1]}"


def format_verdicts_text(found: Recognised, *, full: bool = False) -> str:
    """Format for a reader what is there and why, and what each other model lacks."""
    scene = found.scene
    used, given = len(scene.views), len(found.view_set.views) + found.view_set.left_out
    views = many(given, "view")
    seen = (
        *([views if used == given else f"{used} of {views}"] if given else []),
        many(len(scene.faces), "face"),
        many(len(scene.edges), "edge"),
        many(len(scene.vertices), "vertex", "vertices"),
    )
    head = f"{fit_on_one_line(scene.name)}: {', '.join(seen)}"
    answer = () if found.recognition.best else (NO_MODEL,)
    return "\n".join([head, *answer, *found.recognition.lines(full=full)])


def write_report(
    folder: Path,
    found: Recognised,
    *,
    degrees: "Sequence[Degrees]" = (),
    full: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write scene, facts, verdicts, meshes and drawn views; raise InputError if that cannot be.

    Of views that came one at a time also how `degrees` rose; with `full` the whole proofs. The
    folder appears as a whole when all is written (see output_folder.py).
    """
    from facetlog.kb.loading.encode import iter_program_lines
    from facetlog.page.contents import Subject
    from facetlog.page.write import PAGE_FILE, page
    from facetlog.perception.facts.all_facts import facts_on_demand
    from facetlog.perception.facts.pieces.piece_facts import shown_pieces
    from facetlog.perception.pieces.piece_meshes import export_pieces
    from facetlog.perception.surfaces.mesh_export import write_mesh
    from facetlog.perception.surfaces.scene_file import write_scene

    scene, clock = found.scene, found.clock
    about: dict[str, object] = {
        "facetlog": __version__,
        "scene": scene.name,
        "source": str(found.view_set.source) if found.view_set.source else None,
        "problems": list(found.view_set.problems),
    }
    with output_folder(folder, about) as made:
        with clock.step("write results"):
            write_scene(scene, made / "scene.json")
            # A file can be asked for nothing later.
            drawn = (fact.row for fact in facts_on_demand(scene))
            facts = "\n".join(iter_program_lines((*found.facts, *drawn)))
            (made / "facts.pl").write_text(facts + "\n", encoding="utf-8")
            (made / "verdicts.json").write_text(
                format_verdicts_json(found, full=full) + "\n", encoding="utf-8"
            )
            if scene.faces:
                write_mesh(scene, made / "faces.ply")
                write_mesh(scene, made / "faces.glb")
            pieces = shown_pieces(scene)
            if pieces:
                (made / "pieces.glb").write_bytes(export_pieces(scene, pieces))
        with clock.step("draw pictures"):
            if degrees:
                write_degree_plot(made / DEGREE_FILE, degrees, scene.name)
            if found.view_set.views:
                _write_pictures(made, found, pieces, progress)
        with clock.step("write the page"):
            text = page(Subject.of_run(found, pieces))
            (made / PAGE_FILE).write_text(text, encoding="utf-8")
        about["seconds"] = _list_seconds(clock)


def _write_pictures(
    made: Path, found: Recognised, pieces: "ShownPieces", progress: Progress | None
) -> None:
    """Write the views one by one, and sheets of all: with faces and, if there are any, pieces."""
    from facetlog.perception.pieces.draw_pieces import draw_pieces
    from facetlog.perception.surfaces.drawing.draw import draw_scene

    best = found.recognition.best
    verdict = format_holding(v.summary for v in best)
    parts = {face: p.role for v in reversed(best) for p in v.parts for face in p.faces}
    views = found.placed_views
    faces, solids = [], []
    (made / "views").mkdir()
    for number, view in enumerate(views, start=1):
        image = draw_scene(view, found.scene, parts=parts, verdict=verdict)
        # Numbered, for names may repeat in different folders, and may be no file names at all.
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", Path(view.name).stem)[:80]
        _write_png(made / "views" / f"{number:04d}-{name}.png", image)
        faces.append(_shrink(image))
        if pieces:
            title = f"{found.scene.name}, {view.name}: {many(len(pieces.pieces), 'piece')}"
            solids.append(_shrink(draw_pieces(view, pieces, title, found.scene.up)))
        if progress is not None:
            progress("draw pictures", number, len(views))
    _write_sheet(made / SHEET_FILE, faces)
    if solids:
        _write_sheet(made / PIECES_SHEET_FILE, solids)


def _shrink(image: "ColourImage") -> "ColourImage":
    """Shrink a picture for a sheet."""
    import cv2
    import numpy as np

    shrink = min(1.0, SHEET_PICTURE_PX / image.shape[1])
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _write_sheet(path: Path, images: "Sequence[ColourImage]") -> None:
    from facetlog.perception.surfaces.drawing.draw import contact_sheet

    _write_png(path, contact_sheet(images))


def _write_png(path: Path, image: "ColourImage") -> None:
    import cv2

    _, data = cv2.imencode(".png", image)
    path.write_bytes(data.tobytes())


def _list_seconds(clock: "StepClock") -> dict[str, dict[str, float]]:
    return {
        t.name: {"wall": round(t.wall, 4), "cpu": round(t.cpu, 4)}
        for t in (*clock.times, clock.total)
    }
