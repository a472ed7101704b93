"""`facetlog classify`: classify many scenes or raw shapes into a table of verdicts."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shape_options import StatedOptions
from facetlog.commands.shared import NO, YES, AsJson, JudgingOptions, command
from facetlog.errors import InputError
from facetlog.plurals import many
from facetlog.terminal import fit_on_one_line, note, printable, warn

if TYPE_CHECKING:
    from facetlog.batch.confusion import Confusion
    from facetlog.batch.labels import Label
    from facetlog.batch.outcome import Outcome
    from facetlog.batch.rows import Row
    from facetlog.batch.run import Finished, Plan, Workers
    from facetlog.batch.settings import Item, Settings
    from facetlog.kb.overlaps import Overlaps

__all__ = ["classify_command"]

ERRORS_NAMED = 5
WITH_ERRORS = ("more scene has an error", "more scenes have errors")
"""Scenes with errors that are named on stderr; the table has them all."""


@dataclass(frozen=True, slots=True)
class _RunOptions:
    """How the work is done, and what happens to an earlier table."""

    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", help="Worker processes (default: one per core)."),
    ] = None
    memory: Annotated[
        int | None,
        typer.Option(
            "--memory",
            metavar="MB",
            help="Memory limit per worker (default: its share of the available memory).",
        ),
    ] = None
    timeout: Annotated[
        float,
        typer.Option(
            "--timeout",
            metavar="SECONDS",
            help="CPU time limit per scene; the wall-clock limit is five times that.",
        ),
    ] = 60.0
    keep: Annotated[
        Path | None,
        typer.Option(
            "--keep",
            metavar="DIR",
            help="Folder for the scenes of meshes and for facts (default: in the user's cache).",
        ),
    ] = None
    dask: Annotated[
        str | None,
        typer.Option("--dask", metavar="ADDRESS", help="Scheduler of a dask.distributed cluster."),
    ] = None
    resume: Annotated[bool, typer.Option("--resume", help="Continue a run that was stopped.")] = (
        False
    )
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the table and start over.")
    ] = False
    profile: Annotated[
        bool, typer.Option("--profile", help="Report the time by stage and by model.")
    ] = False
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 1 if a scene had an error.")
    ] = False


@dataclass(frozen=True, slots=True)
class _LabelOptions:
    """The true labels of the scenes, by which answers are counted."""

    labels: Annotated[
        Path | None,
        typer.Option("--labels", metavar="CSV", help="True classes, for a confusion matrix."),
    ] = None
    classes: Annotated[
        str | None,
        typer.Option("--classes", metavar="A,B,...", help="Models that can be the answer."),
    ] = None
    count_as: Annotated[
        list[str] | None,
        typer.Option(
            "--count-as",
            metavar="LABEL=CLASS",
            help="Count a label as a class: 'desk=' leaves it out, 'cabinet=none|box' leaves it "
            "out if the answer is box.",
        ),
    ] = None
    report: Annotated[
        Path | None,
        typer.Option("--report", metavar="HTML", help="Write a report with pictures of mistakes."),
    ] = None


@command
def classify_command(
    judging: JudgingOptions,
    run: _RunOptions,
    known: _LabelOptions,
    stated: StatedOptions,
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENE]...",
            help="Scenes or raw shapes: files, folders (with all their files), or glob patterns.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Table: .parquet, .jsonl or .csv."),
    ] = None,
    listed: Annotated[
        list[str] | None,
        typer.Option(
            "--from",
            metavar="LIST",
            help="File of paths, one per line or separated by NUL; # begins a comment; - is stdin.",
        ),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            "--html", metavar="DIR", help="Also write a page for each scene, in a new folder."
        ),
    ] = None,
    changed_since: Annotated[
        Path | None,
        typer.Option("--changed-since", metavar="TABLE", help="Compare with older results."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Classify many scenes; a scene that cannot be read becomes a row with its error.

    Exit code 0: done, 1: verdicts differ (--changed-since), or a scene had an error (--strict).
    """
    from facetlog.batch.compare import (
        Comparison,
        check_same_options,
        is_table_crisp,
        keep_older_options,
        read_older_rows,
    )
    from facetlog.batch.display import show_rate
    from facetlog.batch.labels import check_model_names, read_labels
    from facetlog.batch.outcome import Outcome
    from facetlog.batch.run import Plan, check_output
    from facetlog.batch.settings import Settings
    from facetlog.output_file import check_distinct
    from facetlog.page.page_path import check_page

    report, models = known.report, judging.paths
    if report is not None and known.labels is None:
        raise InputError("--report shows what went wrong: give --labels as well")
    if known.labels is None and (known.classes or known.count_as):
        raise InputError("--classes and --count-as say what is right: give --labels as well")
    if run.profile and run.dask is not None:
        raise InputError("--profile is of workers of this machine: leave out --dask")
    comparison = None if changed_since is None else Comparison(read_older_rows(changed_since))
    old = {} if comparison is None else comparison.old
    settings = Settings(
        _resolve_models(models),
        judging.trust,
        judging.crisp or is_table_crisp(old),
        stated.up_word,
        stated.unit_word,
        run.timeout,
        run.memory,
        run.profile,
        judging.raw,
        stated.sensor_word,
        stated.override_file,
        None if run.keep is None else _check_kept_folder(run.keep),
    )
    labels = {} if known.labels is None else read_labels(known.labels)
    items = _make_items(_list_paths(scenes or (), listed or (), labels, old), labels)
    items = keep_older_options(items, old, up=stated.up is not None, unit=stated.unit is not None)
    check_same_options(items, settings, old)
    plan = Plan(items, settings, out, run.resume, run.overwrite, old)
    given = (*models, known.labels, changed_since, *map(Path, listed or ()))
    read = [*(path for path in given if path is not None), *(Path(item.place) for item in items)]
    check_distinct((("-o", out), ("--report", report), ("--html", html)))
    check_output(plan, read)
    if report is not None:
        from facetlog.batch.pages.report import write_report

        check_page(report, "--report", read, overwrite=None)  # --overwrite is of the table
    if html is not None:
        from facetlog.batch.pages.scene_pages import check_pages

        check_pages(html, len(items), read, (out, report))
    outcome = Outcome(comparison=comparison, overlaps=_watch_overlaps(settings.models))
    with _open_workers(settings, run, len(items)) as crew:
        if models:
            check_model_names(crew.models)
        if known.labels is not None:
            outcome.confusion = _make_confusion(items, labels, crew.models, known)
        with _run_plan(plan, crew) as done:
            outcome.kept, outcome.seconds = done.kept, done.seconds
            _write_table(done, plan, outcome, as_json=as_json)
            if report is not None and outcome.confusion is not None:
                with show_rate("report", "mistake") as show:
                    write_report(report, outcome, outcome.confusion, done, crew, show)
            if html is not None:
                _write_pages(html, done, crew)
        if run.profile:
            outcome.profile = crew.profile
    _print_outcome(outcome, as_json=as_json and out is not None)
    differ = comparison is not None and bool(comparison.changes)
    return NO if differ or (run.strict and outcome.errors) else YES


def _watch_overlaps(models: Sequence[str]) -> "Overlaps | None":
    """Return the counts of built-in models that hold wherever one of these does, if there are any
    in the model language."""
    if not models:
        return None
    from facetlog.grammar.analysis import analyse
    from facetlog.kb.loading.rule_source import MODEL_SUFFIX
    from facetlog.kb.overlaps import Overlaps, list_stated_orders
    from facetlog.kb.recognize import rule_files

    files = [path for path in rule_files(map(Path, models)) if path.suffix == MODEL_SUFFIX]
    return Overlaps(list_stated_orders(map(analyse, files)))


def _resolve_models(paths: Sequence[Path]) -> tuple[str, ...]:
    """Return the absolute paths of the models, as workers find them wherever they run."""
    for path in paths:
        if not path.exists():
            raise InputError(f"{path} does not exist: give a model file or a folder of them")
    return tuple(str(path.resolve()) for path in paths)


def _check_kept_folder(folder: Path) -> str:
    """Return the absolute path of the folder, which is made if need be; InputError if it is not the
    user's alone to write.
    """
    from facetlog.cache_folder import cache_folder

    try:
        cache_folder("scenes", folder)
    except OSError as exc:
        raise InputError(f"--keep {folder}: cannot be used: {exc.strerror or exc}") from exc
    return str(folder.resolve())


def _list_paths(
    scenes: Sequence[str],
    listed: Sequence[str],
    labels: Mapping[str, "Label"],
    old: Mapping[str, "Row"],
) -> tuple[str, ...]:
    """Return the given scenes; if none are, those with a label, or those of the older table."""
    from facetlog.batch.inputs import find_scene_paths, read_path_list

    named = [path for source in listed for path in read_path_list(source)]
    if not scenes and not named:
        named = [label.file for label in labels.values()] or list(old)
    return find_scene_paths(scenes, named)


def _make_items(paths: Sequence[str], labels: Mapping[str, "Label"]) -> tuple["Item", ...]:
    from facetlog.batch.settings import Item

    if not labels:
        return tuple(map(Item, paths))
    found = ((path, labels.get(os.path.realpath(path))) for path in paths)
    return tuple(
        Item(path) if label is None else Item(path, label.up, label.unit, override=True)
        for path, label in found
    )


@contextmanager
def _open_workers(settings: "Settings", run: _RunOptions, scenes: int) -> Iterator["Workers"]:
    """Start processes on this machine, or connect to the cluster at an address."""
    from facetlog.batch.pool import Pool

    if run.dask is not None:
        if run.workers is not None:
            raise InputError("--workers is of this machine, --dask of a cluster: give one of them")
        from facetlog.batch.dask_cluster import cluster

        with cluster(run.dask, settings) as crew:
            yield crew
        return
    cores = len(os.sched_getaffinity(0))
    with Pool(settings, min(cores if run.workers is None else run.workers, scenes)) as pool:
        yield pool


@contextmanager
def _run_plan(plan: "Plan", crew: "Workers") -> Iterator["Finished"]:
    """Provide classify with a progress display; report how far it came if it is stopped."""
    from facetlog.batch.display import show_rate
    from facetlog.batch.run import classified

    reached = 0
    with ExitStack() as stack:
        try:
            with show_rate() as show:

                def report(done: int, total: int, failed: int) -> None:
                    nonlocal reached
                    reached = done
                    show(done, total, failed)

                finished = stack.enter_context(classified(plan, crew, report))
        except KeyboardInterrupt:
            way_on = "; go on with --resume" if plan.output else ""
            note(f"stopped after {reached} of {many(len(plan.items), 'scene')}{way_on}")
            raise
        yield finished


def _make_confusion(
    items: Sequence["Item"],
    labels: Mapping[str, "Label"],
    models: Sequence[str],
    known: _LabelOptions,
) -> "Confusion":
    """Return the matrix to fill; raise InputError for classes that no model is."""
    from facetlog.batch.confusion import Confusion
    from facetlog.batch.labels import (
        find_labelled_classes,
        iter_unknown_labels,
        parse_class_names,
        truths,
    )

    by_path = {
        item.path: label
        for item in items
        if (label := labels.get(os.path.realpath(item.path))) is not None
    }
    asked = parse_class_names(known.classes or "", models)
    counted_as = truths(known.count_as or (), asked or models)
    occurring = {label.label for label in labels.values()}
    for name in counted_as.keys() - occurring:
        warn(f"--count-as {name}: no label is called so")
    counted_as = {name: truth for name, truth in counted_as.items() if name in occurring}
    for line in iter_unknown_labels(sorted(occurring), models, counted_as):
        warn(f"{line}; --count-as LABEL=CLASS says otherwise")
    return Confusion(
        by_path, asked or find_labelled_classes(models, by_path.values(), counted_as), counted_as
    )


def _write_table(done: "Finished", plan: "Plan", outcome: "Outcome", *, as_json: bool) -> None:
    """Write the rows to their file, or print them where nothing else is printed."""
    from facetlog.batch.output import plain_row, write_rows

    rows = outcome.noting(done.rows())
    if plan.output is not None:
        write_rows(plan.output, rows)
        done.journal.remove()
        return
    silent = outcome.confusion is not None or outcome.comparison is not None
    for row in rows:
        if as_json and not silent:
            typer.echo(json.dumps(plain_row(row)))
        elif not silent:
            typer.echo(_format_row(row))


def _write_pages(folder: Path, done: "Finished", crew: "Workers") -> None:
    """Write the pages, and warn of scenes that have none though they have a row."""
    from facetlog.batch.display import show_rate
    from facetlog.batch.pages.scene_pages import INDEX, write_pages

    try:
        with show_rate("pages", "page") as show:
            missing = write_pages(folder, done, crew, show)
    except KeyboardInterrupt:
        note(f"stopped: no page is in {folder}; with a table, --resume makes them from it")
        raise
    _warn_of([(path, f"no page: {error}") for path, error in missing.items()], *WITH_ERRORS)
    note(f"pages of all scenes are listed in {folder / INDEX}")


def _format_row(row: "Row") -> str:
    from facetlog.batch.rows import read_confidence

    if row["error"] is not None:
        return fit_on_one_line(
            f"{row['path']}: error: {row['error'].removeprefix(row['path'] + ': ')}"
        )
    if row["model"] is None:
        return fit_on_one_line(f"{row['path']}: none")
    sure = read_confidence(row).format(row["degree"])
    return fit_on_one_line(f"{row['path']}: {row['model']} ({sure})")


def _print_outcome(outcome: "Outcome", *, as_json: bool) -> None:
    """Print counts on stdout, and errors on stderr."""
    _warn_of(outcome.errors, *WITH_ERRORS)
    _warn_of(outcome.warnings, "more warning of a scene", "more warnings of scenes")
    note(outcome.summary)
    for hint in () if outcome.overlaps is None else outcome.overlaps.iter_lines():
        note(hint)
    for line in () if outcome.profile is None else outcome.profile.lines():
        typer.echo(printable(line), err=True)
    if as_json:
        typer.echo(json.dumps(outcome.to_json()))
    else:
        for line in outcome.lines():
            typer.echo(printable(line))


def _warn_of(lines: "Sequence[tuple[str, str]]", one: str, several: str) -> None:
    """Name the first scenes with their lines, and say how many more there are."""
    for path, line in lines[:ERRORS_NAMED]:
        warn(line if line.startswith(path) else f"{path}: {line}")
    more = len(lines) - ERRORS_NAMED
    if more > 0:
        warn(many(more, one, several))
