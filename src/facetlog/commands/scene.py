"""`facetlog scene`: show what scenes and raw shapes hold, convert them, and check scenes."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from facetlog.commands.shape_options import Scale, Shape, ShapeArgument, StatedOptions, read
from facetlog.commands.shared import NO, YES, AsJson, Overwrite, command
from facetlog.errors import InputError
from facetlog.output_file import check_output_file
from facetlog.plurals import many
from facetlog.terminal import error, fit_on_one_line, make_short_line, warn

if TYPE_CHECKING:
    from facetlog.perception.facts.all_facts import FactRows
    from facetlog.perception.facts.fact_schema import Value
    from facetlog.perception.scene import Scene
    from facetlog.perception.surfaces.scene_file import SceneFault

__all__ = ["MOST_LINES", "convert_command", "show_command", "validate_command"]

PICTURE_PX = 960

SUMMARY_SCHEMA = "facetlog-scene-summary/1"
FACES_SHOWN = 10
"""Number of faces in the text, the largest first: they tell what a thing is."""
PIECES_SHOWN = 20
"""Number of pieces in the text."""
DIGITS = 4

VALIDATE_SCHEMA = "facetlog-validate/1"
MOST_LINES = 20
"""Number of faults of a file in the text; what is wrong once is often wrong everywhere."""


@command
def show_command(
    shape: ShapeArgument,
    stated: StatedOptions,
    scale: Scale = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="PNG", help="Draw the scene to this file.")
    ] = None,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Show what a scene, mesh or cloud holds: objects, pieces, largest faces, unit, upward axis."""
    if out is not None:
        check_output_file(out, "-o", (shape,), suffixes=(".png",), overwrite=overwrite)
    found = read(shape, stated, scale)
    if out is not None:
        from facetlog.perception.atomic_write import write_atomically
        from facetlog.perception.surfaces.drawing.thumbnail import thumbnail

        write_atomically(out, thumbnail(found.scene, PICTURE_PX))
    summary = _Summary(found)
    for line in found.scene.warnings:
        warn(line)
    if as_json:
        typer.echo(json.dumps(summary.to_json(), allow_nan=False))
        return YES
    for line in summary.lines():
        # A name that holds what cannot be printed costs its line the columns.
        typer.echo(line if line.isprintable() else fit_on_one_line(line))
    return YES


@dataclass(frozen=True)
class _Summary:
    """A shape's things and faces, with the names that verdicts give them (t1, f1)."""

    shape: Shape

    @cached_property
    def _facts(self) -> "FactRows":
        from facetlog.perception.facts.all_facts import fact_rows

        return fact_rows(self.shape.scene)

    @cached_property
    def pieces(self) -> list[dict[str, Any]]:
        """The pieces: of which thing and shape each is, its sizes, and what it stands on; without a
        known up it stands on nothing."""
        from facetlog.perception.facts.all_facts import fact_rows
        from facetlog.perception.pieces.shown_pieces import choose_kind

        kinds = "piece_of", "piece_size", "piece_heights", "piece_on_ground", "carries", "joins"
        rows = fact_rows(self.shape.scene, kinds)
        owners, sizes = ({row[0]: row[1:] for row in rows.get(kind, ())} for kind in kinds[:2])
        grounded = {row[0] for row in rows.get("piece_on_ground", ())}
        touching = set(rows.get("joins", ()))
        found = []
        for piece, (thing,) in owners.items():
            length, width, thickness, _ = map(float, sizes[piece])
            on = [a for a, b in rows.get("carries", ()) if b == piece and (a, b) in touching]
            shape = choose_kind(length, width, thickness).value
            lengths = {"length": length, "width": width, "thickness": thickness}
            stands = {"on_ground": piece in grounded, "on": on}
            found.append({"name": piece, "thing": thing, "shape": shape, **lengths, **stands})
        return found

    def _index_rows(self, functor: str) -> "dict[Value, tuple[Value, ...]]":
        """Return the arguments of a fact's rows after the first, by the first."""
        return {row[0]: row[1:] for row in self._facts.get(functor, ())}

    @cached_property
    def _owners(self) -> "dict[Value, Value]":
        return {part: thing for part, (thing,) in self._index_rows("part_of").items()}

    @cached_property
    def things(self) -> list[dict[str, Any]]:
        """The things: how many faces each has, its size, and what is known of its surface."""
        sizes, curved, whole = map(self._index_rows, ("thing_size", "curved", "whole"))
        faces = [self._owners.get(name) for name in self._index_rows("face")]
        found = []
        for thing in self._index_rows("thing"):
            lengths = dict(
                zip(("length", "width", "height"), sizes.get(thing, (None,) * 3), strict=True)
            )
            surface = {"curved": curved.get(thing, (None,))[0], "whole": thing in whole}
            found.append({"name": thing, "faces": faces.count(thing), **lengths, **surface})
        return found

    @cached_property
    def faces(self) -> list[dict[str, Any]]:
        """The faces, the largest first; without a known up they have no tilt."""
        functors = ("area", "length", "width", "tilt", "coverage")
        columns = {functor: self._index_rows(functor) for functor in functors}
        sights = self._collect_sights()
        found: list[dict[str, Any]] = []
        for face in self._index_rows("face"):
            values = {f: rows.get(face, (None,))[0] for f, rows in columns.items()}
            thing = self._owners.get(face)
            found.append({"name": face, "thing": thing, **values, "sights": sights[face]})
        # Areas that read the same are the same: rounding orders nothing.
        return sorted(found, key=lambda face: -float(f"{face['area']:.{DIGITS}g}"))

    def _collect_sights(self) -> "dict[Value, list[dict[str, Any]]]":
        """Return by face each view, what it shows of the face, and which faces hide it there."""
        scene = self.shape.scene
        return {
            f"f{number}": [
                {
                    "view": scene.views[sight.view],
                    "seen": sight.seen,
                    "hidden": {f"f{by + 1}": share for by, share in sight.hidden},
                    "outside": sight.outside,
                }
                for sight in face.sights
            ]
            for number, face in enumerate(scene.faces, start=1)
        }

    def to_json(self) -> dict[str, Any]:
        """Return all of it: lengths in metres if `unit` is "m", angles in degrees."""
        scene = self.shape.scene
        return {
            "schema": SUMMARY_SCHEMA,
            "name": scene.name,
            "unit": "m" if scene.metric else None,
            "unit_known": self.shape.unit_known,
            "up": None if scene.up is None else scene.up.tolist(),
            "up_known": self.shape.up_known,
            "views": len(scene.views),
            "vertices": len(scene.vertices),
            "edges": len(scene.edges),
            "patches": len(scene.patches),
            "things": self.things,
            "pieces": self.pieces,
            "faces": self.faces,
            "warnings": list(scene.warnings),
        }

    def lines(self) -> Iterator[str]:
        """Format all things and the largest faces as text."""
        scene, things, faces = self.shape.scene, self.things, self.faces
        yield (
            f"{scene.name}: {many(len(things), 'object')}, {many(len(faces), 'face')}, "
            f"{many(len(scene.edges), 'edge')}, {many(len(scene.vertices), 'vertex', 'vertices')}"
        )
        unit = "metres" if scene.metric else "unknown, only ratios of lengths mean something"
        up = "unknown" if scene.up is None else " ".join(f"{x:.3g}" for x in scene.up + 0.0)
        known = (("unit  ", unit, self.shape.unit_known), ("up    ", up, self.shape.up_known))
        for name, value, how in known:
            yield f"{name}{value}" + ("" if how == "not known" else f", {how}")
        if scene.views:
            yield f"seen  in {many(len(scene.views), 'view')}"
        metres, square = (" (m)", " (m²)") if scene.metric else ("", "")
        if things:
            sizes = (f"{name}{metres}" for name in ("longest", "middle", "shortest"))
            yield ""
            yield from _format_table(
                ("object", "faces", *sizes, "curved", "whole"), map(_format_thing, things)
            )
        if pieces := self.pieces:
            sizes = (f"{name}{metres}" for name in ("length", "width", "thickness"))
            yield ""
            yield from _format_table(
                ("piece", "object", "shape", *sizes, "stands on"),
                map(_format_piece, pieces[:PIECES_SHOWN]),
            )
            if len(pieces) > PIECES_SHOWN:
                yield f"and {len(pieces) - PIECES_SHOWN} more"
        if faces:
            heads = (f"area{square}", f"length{metres}", f"width{metres}")
            yield ""
            yield from _format_table(
                ("face", "object", *heads, "tilt", "seen"), map(_format_face, faces[:FACES_SHOWN])
            )
            if len(faces) > FACES_SHOWN:
                yield f"and {len(faces) - FACES_SHOWN} smaller"


def _format_number(value: float | None, form: str = f".{DIGITS}g") -> str:
    return "–" if value is None else f"{value:{form}}"


def _format_thing(thing: dict[str, Any]) -> tuple[str, ...]:
    sizes = (_format_number(thing[name]) for name in ("length", "width", "height"))
    curved, whole = _format_number(thing["curved"], ".0%"), "yes" if thing["whole"] else "no"
    return (str(thing["name"]), str(thing["faces"]), *sizes, curved, whole)


def _format_piece(piece: dict[str, Any]) -> tuple[str, ...]:
    sizes = (_format_number(piece[name]) for name in ("length", "width", "thickness"))
    on = ", ".join(map(str, [*(["ground"] if piece["on_ground"] else []), *piece["on"]])) or "–"
    return (str(piece["name"]), str(piece["thing"]), piece["shape"], *sizes, on)


def _format_face(face: dict[str, Any]) -> tuple[str, ...]:
    sizes = (_format_number(face[name]) for name in ("area", "length", "width"))
    tilt = "–" if face["tilt"] is None else f"{face['tilt']:.1f}°"
    return (
        face["name"],
        face["thing"] or "–",
        *sizes,
        tilt,
        _format_number(face["coverage"], ".0%"),
    )


def _format_table(heads: Sequence[str], rows: Iterator[tuple[str, ...]]) -> Iterator[str]:
    """Format columns of equal width, names to the left and numbers to the right."""
    table = [tuple(heads), *rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for first, *others in table:
        numbers = (cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True))
        yield "  ".join((first.ljust(widths[0]), *numbers)).rstrip()


@command
def convert_command(
    shape: ShapeArgument,
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="Scene (.json), mesh of its faces (.ply, .glb, .gltf), or facts (.pl); with "
            "--pieces a mesh of its pieces (.glb).",
            show_default=False,
        ),
    ],
    stated: StatedOptions,
    scale: Scale = None,
    pieces: Annotated[
        bool,
        typer.Option(
            "--pieces",
            help="Write a mesh of the pieces, coloured by kind, with unseen space translucent.",
        ),
    ] = False,
    overwrite: Overwrite = False,
) -> int:
    """Write a scene, mesh or cloud in another form, which the suffix of OUT chooses."""
    writers = {".glb": _write_pieces} if pieces else _WRITERS
    check_output_file(out, "OUT", (shape,), suffixes=tuple(writers), overwrite=overwrite)
    scene = read(shape, stated, scale).scene
    for line in scene.warnings:
        warn(line)
    writers[out.suffix.lower()](scene, out)
    return YES


def _write_scene(scene: "Scene", path: Path) -> None:
    from facetlog.perception.facts.most_faces import MOST_FACES
    from facetlog.perception.surfaces.scene_file import SceneFileError, write_scene
    from facetlog.perception.surfaces.scene_json.scene_checks import find_scene_faults

    if faults := tuple(find_scene_faults(scene)):  # it could not be read again
        raise SceneFileError(f"{path} is not written: the scene", faults)
    write_scene(scene, path)
    if len(scene.faces) > MOST_FACES:
        warn(
            f"{path}: has {len(scene.faces):,} faces: it can be shown, but of at most "
            f"{MOST_FACES:,} facts are made, so it is not judged: leave out what does not matter"
        )


def _write_mesh(scene: "Scene", path: Path) -> None:
    from facetlog.perception.surfaces.mesh_export import write_mesh

    write_mesh(scene, path)
    if scene.patches:
        warn(f"{path}: holds the flat faces alone; surface that is not flat has no triangles")


def _write_pieces(scene: "Scene", path: Path) -> None:
    from facetlog.perception.atomic_write import write_atomically
    from facetlog.perception.facts.pieces.piece_facts import shown_pieces
    from facetlog.perception.pieces.piece_meshes import export_pieces

    write_atomically(path, export_pieces(scene, shown_pieces(scene)))


def _write_facts(scene: "Scene", path: Path) -> None:
    from facetlog.kb.loading.encode import iter_program_lines
    from facetlog.perception.atomic_write import write_atomically
    from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts

    # All of them: a file cannot be asked for more later.
    facts = (fact.row for fact in (*scene_facts(scene), *facts_on_demand(scene)))
    write_atomically(path, ("\n".join(iter_program_lines(facts)) + "\n").encode())


_WRITERS = {
    ".json": _write_scene,
    ".ply": _write_mesh,
    ".glb": _write_mesh,
    ".gltf": _write_mesh,
    ".pl": _write_facts,
}


@command
def validate_command(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Scene files (JSON).", show_default=False),
    ],
    as_json: AsJson = False,
) -> int:
    """Check scene files against the schema facetlog-scene/1, and their geometry for consistency.

    Exit code 0: all are sound, 1: some are not, 2: a file cannot be read.
    """
    code, sound = YES, 0
    for path in files:
        try:
            faults = _find_faults(path)
        except InputError as exc:  # the other files are checked all the same
            error(str(exc))
            code = exc.exit_code
            continue
        sound += not faults
        code = max(code, NO if faults else YES)
        if as_json:
            found = [{"path": fault.path, "message": fault.message} for fault in faults]
            report = {"file": str(path), "sound": not faults, "faults": found}
            typer.echo(json.dumps({"schema": VALIDATE_SCHEMA, **report}))
            continue
        for fault in faults[:MOST_LINES]:
            typer.echo(make_short_line(f"{path}: {fault}"))
        if len(faults) > MOST_LINES:
            more = many(len(faults) - MOST_LINES, "more fault")
            typer.echo(fit_on_one_line(f"{path}: {more}: --json has them all"))
    if not as_json:
        typer.echo(f"{many(len(files), 'file')}, {'all' if sound == len(files) else sound} sound")
    return code


def _find_faults(path: Path) -> "tuple[SceneFault, ...]":
    """Return the faults for which every reader refuses a scene file."""
    from facetlog.perception.surfaces.scene_file import SceneFileError, read_scene
    from facetlog.query_shell.scene_files import is_raw_shape

    if is_raw_shape(path):
        raise InputError(
            f"{path}: is a mesh or a cloud, no scene: make one of it by facetlog scene convert"
        )
    try:
        read_scene(path)
    except SceneFileError as exc:
        return exc.faults
    return ()
