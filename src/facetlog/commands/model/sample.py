"""`facetlog model sample`: solids that a model describes, and near misses, with labels."""

import csv
import io
import json
from collections import Counter
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.drawn import (
    EFFORT,
    Effort,
    ModelName,
    conflict_lines,
    model_errors,
    workbench,
)
from facetlog.commands.shared import NO, YES, AsJson, Models, Trust, command

if TYPE_CHECKING:
    from collections.abc import Sequence

    from facetlog.prototype.samples import Sample
    from facetlog.prototype.search import Search

__all__ = ["sample_command"]

SCHEMA = "facetlog-samples/1"
LABELS = "labels.csv"
EXPECTED = "expected.csv"
SHEET = "samples.png"


@command
def sample_command(
    name: ModelName,
    models: Models = None,
    trust: Trust = False,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="The folder; samples/NAME if not given."),
    ] = None,
    count: Annotated[
        int, typer.Option("-n", "--count", metavar="N", min=1, help="So many scenes in all.")
    ] = 20,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Another gives other scenes.")] = 0,
    effort: Effort = EFFORT,
    as_json: AsJson = False,
) -> int:
    """Makes scenes that a model describes, half of them, and near misses that fail one condition.

    The folder gets the scenes, labels.csv for `classify --labels`, expected.csv for `model test
    --scenes`, and samples.png. Exit code as of `model draw`.
    """
    from facetlog.output_folder import check_replaceable, output_folder
    from facetlog.prototype.search import searched
    from facetlog.terminal import printable

    models = models or []
    if faults := model_errors(name, models):
        typer.echo(faults)
        return NO
    folder = out or Path("samples") / Path(name).stem
    check_replaceable(folder, inputs=models)
    with workbench(name, models, trust=trust) as bench:
        search = searched(bench, effort)
        if not search.best.judged.holds:
            typer.echo("\n".join(map(printable, conflict_lines(search))))
            return NO
        samples, never = _samples(search, count, seed)
        about = {"command": "model sample", "model": bench.model, "seed": seed}
        with output_folder(folder, about) as made:
            _write(bench.model, samples, made)
        counts = Counter(sample.fails for sample in samples)
        if as_json:
            data = {"schema": SCHEMA, "model": bench.model, "samples": counts, "never_alone": never}
            typer.echo(json.dumps(data))
            return YES
        typer.echo(printable(f"{folder}: {counts.pop('', 0)} hold as {bench.model}"))
        for label, found in counts.items():
            typer.echo(printable(f"{found} near misses fail {label} alone"))
        if never:
            typer.echo(printable(f"no near miss was found that fails alone: {', '.join(never)}"))
    return YES


def _samples(search: "Search", count: int, seed: int) -> "tuple[list[Sample], list[str]]":
    """The samples, and the conditions that none fails alone."""
    from facetlog.prototype.samples import explored, holding_samples, near_misses

    explored(search, seed)
    labels = [
        condition.label
        for condition in search.best.judged.verdict.conditions
        if condition.proof.name != "expect"
    ]
    misses = near_misses(search, seed, labels)
    turns = cycle(misses.values())
    missing = [next(next(turns)) for _ in range(count // 2)] if misses else []
    holding = list(islice(holding_samples(search, seed), count - len(missing)))
    return [*holding, *missing], [label for label in labels if label not in misses]


def _write(model: str, samples: "Sequence[Sample]", folder: Path) -> None:
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
