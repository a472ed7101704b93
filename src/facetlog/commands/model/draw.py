"""`facetlog model draw` and `model sample`: solids that a model describes, and near misses."""

import csv
import io
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shape_options import StatedOptions
from facetlog.commands.shared import NO, YES, AsJson, ModelOptions, Overwrite, command
from facetlog.errors import InputError
from facetlog.terminal import printable, show_progress

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis
    from facetlog.grammar.syntax import Example
    from facetlog.prototype.samples import Sample
    from facetlog.prototype.search import Search
    from facetlog.prototype.workbench import Workbench

__all__ = ["draw_command", "sample_command"]

DRAW_SCHEMA, SAMPLE_SCHEMA = "facetlog-prototype/1", "facetlog-samples/1"
PICTURE_PX = 960
LABELS, EXPECTED, SHEET = "labels.csv", "expected.csv", "samples.png"
EFFORT = 240
"""Default number of solids to try: some two minutes where none holds."""

ModelName = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="A built-in model, one of --models, or a .model file with one model.",
        show_default=False,
    ),
]
Effort = Annotated[
    int, typer.Option("--effort", metavar="N", min=1, help="Largest number of solids to try.")
]

SUFFIX = ".model"


@command
def draw_command(
    name: ModelName,
    models: ModelOptions,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            metavar="OUT",
            help="Output folder (default: drawn/NAME); with --example a .png file.",
        ),
    ] = None,
    example: Annotated[
        str | None,
        typer.Option(
            "--example", metavar="TITLE", help="Draw this example of the model, and judge it."
        ),
    ] = None,
    effort: Effort = EFFORT,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Draw a solid that a model describes, with its measures in the middle of their limits.

    Write NAME.png, NAME.glb and NAME.json. With --example, write one of the model's examples as a
    picture. Exit code 0: the model holds for what is drawn, 1: it does not (the conditions that
    were never met together are listed), or the model has errors.
    """
    from facetlog.output_folder import check_replaceable, output_folder
    from facetlog.prototype.search import searched

    if faults := _find_errors(name, models.paths):
        typer.echo(faults)
        return NO
    if example is not None:
        return _draw_example(name, example, models, out, overwrite=overwrite, as_json=as_json)
    folder = out or Path("drawn") / Path(name).stem
    check_replaceable(folder, inputs=models.paths)
    with _open_workbench(name, models, effort) as bench:
        search = searched(bench, effort)
        if not search.best.judged.holds:
            lines = list(_explain_conflict(search))
            if as_json:
                typer.echo(json.dumps(_to_json(search) | {"conflict": lines}))
            else:
                typer.echo("\n".join(map(printable, lines)))
            return NO
        with output_folder(folder, {"command": "model draw", "model": bench.model}) as made:
            _write_drawing(search, made)
        if as_json:
            typer.echo(json.dumps(_to_json(search)))
        else:
            best = search.best
            written = f"{folder / bench.model}.png, .glb, .json"
            typer.echo(printable(f"{written}: the best of {bench.judged} that were judged"))
            typer.echo(printable(best.form.described(best.judged.sizes)))
            typer.echo("\n".join(map(printable, best.judged.verdict.lines())))
    return YES


def _draw_example(
    name: str, title: str, models: ModelOptions, out: Path | None, *, overwrite: bool, as_json: bool
) -> int:
    """Write an example of a model as a picture; return the exit code."""
    from facetlog.commands.model.scenes import ExampleScenes
    from facetlog.kb.recognize import open_knowledge_base
    from facetlog.output_file import check_output_file
    from facetlog.perception.atomic_write import write_atomically
    from facetlog.pipeline import load_scene
    from facetlog.prototype.picture import picture

    path = out or Path(f"{title}.png")
    check_output_file(path, "-o", models.paths, suffixes=(".png",), overwrite=overwrite)
    model, example, file = _find_example(name, title, models.paths)
    scene = ExampleScenes(trusted=models.trust).open(example.scene, file)
    with open_knowledge_base(_list_files(name, models.paths), trusted=models.trust) as base:
        load_scene(base, scene)
        verdict = base.why(scene.name, model)
    write_atomically(path, picture(scene, verdict, PICTURE_PX))
    if as_json:
        typer.echo(json.dumps({"schema": DRAW_SCHEMA, "model": model, "example": title,
                               "picture": str(path), "verdict": verdict.to_json()}))  # fmt: skip
    else:
        typer.echo(printable(f"{path}: {verdict.summary}"))
    return YES if verdict.state.value == "holds" else NO


def _find_example(name: str, title: str, models: Sequence[Path]) -> "tuple[str, Example, Path]":
    """Return the model's name, the example of this title, and the model's file.

    Raise InputError, with the titles that there are, if there is none.
    """
    from facetlog.commands.model.check import analysed
    from facetlog.grammar.example_scenes import list_examples
    from facetlog.grammar.library import BUILTIN
    from facetlog.kb.recognize import rule_files

    files = (
        [Path(name)] if name.endswith(SUFFIX) else [*rule_files(models), BUILTIN / f"{name}.model"]
    )
    titles: list[str] = []
    for file in files:
        if file.suffix != SUFFIX or not file.exists():
            continue
        for model, example in list_examples(analysed(file)):
            if name.endswith(SUFFIX) or model.name.text == name:
                if example.title.value == title:
                    return model.name.text, example, file
                titles.append(example.title.value)
    known = "; ".join(f'"{one}"' for one in titles) or "none"
    raise InputError(f'{name} has no example "{title}": there are {known}')


def _write_drawing(search: "Search", folder: Path) -> None:
    from facetlog.perception.surfaces.mesh_export import write_mesh
    from facetlog.perception.surfaces.scene_file import write_scene
    from facetlog.prototype.picture import picture

    scene, name = search.best.judged.scene, search.bench.model
    verdict = search.best.judged.verdict
    (folder / f"{name}.png").write_bytes(picture(scene, verdict, PICTURE_PX))
    write_mesh(scene, folder / f"{name}.glb")
    write_scene(scene, folder / f"{name}.json")


def _to_json(search: "Search") -> dict[str, object]:
    best = search.best
    return {
        "schema": DRAW_SCHEMA,
        "model": search.bench.model,
        "form": best.form.name,
        "sizes": dict(best.judged.sizes),
        "judged": search.bench.judged,
        "verdict": best.judged.verdict.to_json(),
    }


@command
def sample_command(
    name: ModelName,
    models: ModelOptions,
    stated: StatedOptions,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="Output folder (default: samples/NAME)."),
    ] = None,
    count: Annotated[
        int, typer.Option("-n", "--count", metavar="N", min=1, help="Number of scenes.")
    ] = 20,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Random seed.")] = 0,
    like: Annotated[
        Path | None,
        typer.Option(
            "--like", metavar="MESH", help="Stretch and turn this mesh instead of searching solids."
        ),
    ] = None,
    effort: Effort = EFFORT,
    as_json: AsJson = False,
) -> int:
    """Make scenes: half match a model, half are near misses that fail one condition.

    Write the scenes, labels.csv for `classify --labels`, expected.csv for `model test --scenes`,
    and samples.png. Exit codes as of `model draw`.
    """
    from facetlog.output_folder import check_replaceable, output_folder

    if faults := _find_errors(name, models.paths):
        typer.echo(faults)
        return NO
    folder = out or Path("samples") / Path(name).stem
    check_replaceable(folder, inputs=[*models.paths, *([like] if like else [])])
    with _open_workbench(name, models, effort) as bench:
        search = _find_samples(bench, like, stated, effort)
        if not search.best.judged.holds:
            typer.echo("\n".join(map(printable, _explain_conflict(search))))
            return NO
        samples, never = _make_samples(search, count, seed)
        about = {"command": "model sample", "model": bench.model, "seed": seed}
        with output_folder(folder, about) as made:
            _write_samples(bench.model, samples, made)
        counts = Counter(sample.fails for sample in samples)
        if as_json:
            data = {
                "schema": SAMPLE_SCHEMA,
                "model": bench.model,
                "samples": counts,
                "never_alone": never,
            }
            typer.echo(json.dumps(data))
            return YES
        typer.echo(printable(f"{folder}: {counts.pop('', 0)} hold as {bench.model}"))
        for label, found in counts.items():
            typer.echo(printable(f"{found} near misses fail {label} alone"))
        if never:
            typer.echo(printable(f"no near miss was found that fails alone: {', '.join(never)}"))
    return YES


def _find_samples(
    bench: "Workbench", like: Path | None, stated: StatedOptions, effort: int
) -> "Search":
    """Return a search that found what to vary: a mesh, or any solids that hold."""
    from facetlog.prototype.mesh_form import read_mesh_form
    from facetlog.prototype.search import Search, searched

    if like is None:
        return searched(bench, effort)
    search = Search(bench, effort)
    search.look([read_mesh_form(like, stated.to_shape_options())])
    return search


def _make_samples(search: "Search", count: int, seed: int) -> "tuple[list[Sample], list[str]]":
    """Return the samples, and the conditions that none fails alone."""
    from facetlog.prototype.samples import explored, iter_holding_samples, near_misses

    explored(search, seed)
    labels = [
        condition.label
        for condition in search.best.judged.verdict.conditions
        if condition.proof.name != "expect"
    ]
    misses = near_misses(search, seed, labels)
    turns = cycle(misses.values())
    missing = [next(next(turns)) for _ in range(count // 2)] if misses else []
    holding = list(islice(iter_holding_samples(search, seed), count - len(missing)))
    return [*holding, *missing], [label for label in labels if label not in misses]


def _write_samples(model: str, samples: "Sequence[Sample]", folder: Path) -> None:
    from facetlog.perception.surfaces.drawing.thumbnail import contact_sheet
    from facetlog.perception.surfaces.scene_file import write_scene

    labels: list[tuple[str, ...]] = [("file", "label", "kind", "form")]
    expected: list[tuple[str, ...]] = [("scene", "model", "expected")]
    shown = []
    for nth, sample in enumerate(samples, start=1):
        file = f"{model}_{nth:03}.json"
        write_scene(sample.judged.scene, folder / file)
        fails = sample.fails
        label = f"near {model}" if fails else model
        labels.append((file, label, f"fails {fails}" if fails else "holds", sample.form.name))
        expected.append((file, model, "fails" if fails else "holds"))
        shown.append((sample.judged.scene, f"{label}: fails {fails}" if fails else label))
    for name, rows in ((LABELS, labels), (EXPECTED, expected)):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        (folder / name).write_text(text.getvalue(), encoding="utf-8")
    (folder / SHEET).write_bytes(contact_sheet(shown))


def _find_errors(name: str, models: Sequence[Path]) -> str:
    """Return the errors of the model files among those that are meant, as text."""
    from facetlog.commands.model.check import checked
    from facetlog.commands.model.fault_text import distinct, format_faults_text
    from facetlog.grammar.faults import Severity
    from facetlog.kb.recognize import rule_files

    files = [path for path in rule_files(_list_files(name, models)) if path.suffix == SUFFIX]
    looks = [checked(path) for path in files]
    for analysis, _ in looks:
        _check_one_thing(analysis, name)
    faults = distinct(fault for _, found in looks for fault in found)
    errors = [fault for fault in faults if fault.severity is Severity.ERROR]
    return format_faults_text(files, errors) if errors else ""


def _check_one_thing(analysis: "Analysis", name: str) -> None:
    """Raise InputError if the model that is meant is made of several things."""
    own = Path(name).name == Path(analysis.file.source.name).name
    for model in analysis.models:
        scope = analysis.scopes.get(model)
        if (own or model == name) and scope is not None and scope.of_things:
            raise InputError(f"{model} is made of several things: what is drawn is one solid")


def _list_files(name: str, models: Sequence[Path]) -> list[Path]:
    return [*models, *([Path(name)] if name.endswith(SUFFIX) else [])]


@contextmanager
def _open_workbench(name: str, models: ModelOptions, effort: int) -> "Iterator[Workbench]":
    """Open what judges solids by the model that is meant, and shows how many of them it judged;
    InputError if it is not clear which model that is.
    """
    from facetlog.kb.recognize import open_knowledge_base
    from facetlog.prototype.workbench import Workbench

    with open_knowledge_base(_list_files(name, models.paths), trusted=models.trust) as base:
        if name.endswith(SUFFIX):
            path = Path(name).resolve()
            inside = [model for model, rules in base.models.items() if rules.path == path]
            if len(inside) != 1:
                known = ", ".join(inside) or "none"
                raise InputError(
                    f"{name} has several models: {known}; name one, and give --models {name}"
                )
            name = inside[0]
        elif name not in base.models:
            raise InputError(f"there is no model {name}; there are {', '.join(base.models)}")
        with show_progress() as progress:

            def report(judged: int) -> None:
                if progress is not None:
                    progress("solids tried", judged, max(judged, effort))

            yield Workbench(base, name, report)


def _explain_conflict(search: "Search") -> Iterator[str]:
    """List the conditions that no solid met together, with their places, and what to do."""
    from facetlog.prototype.conflict import conflict

    bench = search.bench
    labels = conflict(search)
    conditions = {c.label: c for c in search.best.judged.verdict.conditions}
    together = " together" if len(labels) > 1 else ""
    yield (
        f"{bench.model}: of {bench.judged} solids that were tried, upright cuboids laid together "
        f"and what examples build, none meets {', '.join(labels)}{together}; other things may, "
        "and --effort tries more"
    )
    for label in labels:
        condition = conditions.get(label)
        if condition is None:
            yield f"  - {label}: no face or piece of any solid is as this part should be"
        else:
            origin = condition.origin
            yield f"  - {label}: {condition.said}{origin}"
    best = search.best
    yield f"the nearest is {best.form.described(best.judged.sizes)}"
    for line in best.judged.verdict.iter_miss_lines():
        yield f"  {line}"
