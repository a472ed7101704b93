"""`facetlog model new`, `list`, `show`, `words` and `lsp`: what people who write models need."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from difflib import get_close_matches
from pathlib import Path
from string import Template
from textwrap import TextWrapper
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.model.files import is_stdin, model_files, read_stdin
from facetlog.commands.shared import YES, AsJson, command
from facetlog.errors import InputError
from facetlog.terminal import fit_on_one_line, printable

if TYPE_CHECKING:
    from facetlog.glossary import Entry

__all__ = ["list_command", "lsp_command", "new_command", "show_model_command", "words_command"]

TEMPLATE = Template(
    """\
# A model says what a thing is: its parts, and what must be true of them. Change it as you need:
#   facetlog model check $file      says what is wrong with it
#   facetlog model test $file       runs the examples below
#   facetlog recognize VIEWS --models $file

model $name
  "A level board on legs."

  # Parts. A board is thin, a bar slender, a block neither, a piece any of them. `board top` is one;
  # `leg` is every bar that satisfies what follows `where`.
  board top
  at least 3 bars leg where leg carries top, leg is on_ground

  # Conditions, one a line: a label, what must be so, and the reason in words for the verdict.
  level: top is level                                  "it lies level"
  wide: cover(top) at least 80 %                       "it covers the thing"
  room: free_below(top) at least 50 %                  "there is room beneath it"
  bare: there is no piece other where other above top  "nothing is above it"

  # Absolute sizes count only where the scale is known; `expect` lowers the degree, and forbids
  # nothing.
  expect: if known: elevation(top) between 30 cm and 120 cm  "it is of a usual height"

  size length, width: length(top), width(top)

  # Examples are tests. `from "own.ply" (up z, unit m)` takes a mesh, cloud or scene of your own.
  example "dining table" of table(width 80 cm, length 140 cm, height 74 cm) holds
  example "closed block" of cuboid(width 80 cm, depth 80 cm, height 74 cm) fails because top
"""
)


@command
def new_command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the model, or NAME.model.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="File to write (default: NAME.model)."),
    ] = None,
) -> int:
    """Write a model to start from, which passes its check and its examples."""
    from facetlog.grammar.analysis import analyse

    # NAME may be given as the name of the file.
    path = out or (Path(name) if name.endswith(".model") else Path(f"{name}.model"))
    name = Path(name).name.removesuffix(".model")
    if path.suffix != ".model":
        raise InputError(f"{path}: models are in files named .model")
    text = TEMPLATE.substitute(name=name, file=path.name)
    faults = analyse(path, text).errors
    if faults or not name.isidentifier():
        why = f": {faults[0].message}" if faults else ""
        raise InputError(f"{name!r} is no name for a model{why}; take a word as coffee_table")
    _write_new(path, text)
    typer.echo(fit_on_one_line(str(path)))
    return YES


def _write_new(path: Path, text: str) -> None:
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f"{path} is there already: give another name, or -o FILE") from None
    except OSError as exc:
        raise InputError(f"{path} cannot be written: {exc.strerror}") from exc


@command
def list_command(
    files: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FILE]...", help="Model files or folders of them (default: the built-in)."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """List the built-in models, or those of files, each with its description."""
    from facetlog.grammar.library import BUILTIN, list_builtin_names, read_text
    from facetlog.grammar.reading.parse import parse
    from facetlog.grammar.source import Source

    builtin = (BUILTIN / f"{name}.model" for name in sorted(list_builtin_names()))
    rows = []
    for path in model_files(files) if files else builtin:
        try:
            source = Source(str(path), read_stdin() if is_stdin(path) else read_text(path))
        except (OSError, ValueError) as exc:
            raise InputError(f"{path} cannot be read: {exc}") from exc
        for model in parse(source).file.models:
            text = model.doc.value if model.doc else ""
            rows.append({"name": model.name.text, "text": text, "path": str(path)})
    if not rows:
        raise InputError(f"{fit_on_one_line(' '.join(files or ()))}: no model is in it")
    if as_json:
        typer.echo(json.dumps(rows, indent=1))
        return YES
    width = max(len(row["name"]) for row in rows)
    for row in rows:
        typer.echo(printable(f"{row['name']:<{width}}  {row['text']}".rstrip()))
    return YES


@command
def show_model_command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A built-in model.")],
) -> int:
    """Print the text of a built-in model, to read or to copy and change."""
    from facetlog.grammar.library import BUILTIN, list_builtin_names, read_text

    if name not in list_builtin_names():
        raise InputError(f"{fit_on_one_line(name)}: no such model; facetlog model list lists them")
    typer.echo(read_text(BUILTIN / f"{name}.model"), nl=False)
    return YES


_WRAPPER = TextWrapper(100, subsequent_indent="    ", break_on_hyphens=False)


@command
def words_command(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[WORD|TOPIC]...", help="Words, or topics such as measures."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Explain words of models and questions; without a word list them by topic."""
    from facetlog.glossary import list_entries

    entries = list_entries()
    found = {name: [e for e in entries if name in (e.topic, e.name)] for name in names or ()}
    chosen = [e for some in found.values() for e in some] if names else entries
    unknown = [name for name, some in found.items() if not some]
    if unknown and not chosen:
        raise InputError(_describe_unknown(unknown, entries))
    if as_json:
        typer.echo(json.dumps([asdict(entry) for entry in chosen], indent=1))
    elif names:
        for line in _format_entries(names, chosen):
            typer.echo(line)
    else:
        for line in _format_topics(chosen):
            typer.echo(line)
    if unknown:
        raise InputError(_describe_unknown(unknown, entries))
    return YES


def _describe_unknown(names: Sequence[str], entries: Sequence["Entry"]) -> str:
    """Return that there are no such words or topics; each with what is spelt almost the same."""
    from facetlog.grammar.faults import is_slip

    known = {text for entry in entries for text in (entry.topic, entry.name)}
    said = []
    for name in names:
        near = next((x for x in get_close_matches(name, known) if is_slip(name, x)), None)
        said.append(f"{fit_on_one_line(name)}{f' (did you mean {near}?)' if near else ''}")
    return f"{', '.join(said)}: no such word or topic; facetlog model words lists all by topic"


def _format_topics(entries: Sequence["Entry"]) -> Iterator[str]:
    names: dict[str, dict[str, None]] = {}
    for entry in entries:
        names.setdefault(entry.topic, {})[entry.name] = None
    for topic, words in names.items():
        yield _WRAPPER.fill(f"{topic}: {', '.join(words)}")


def _format_entries(names: Sequence[str], entries: Sequence["Entry"]) -> Iterator[str]:
    """Format each entry of a topic in short, and each entry of a word with its remarks."""
    for entry in entries:
        yield _WRAPPER.fill(f"{entry.usage}: {entry.meaning}")
        if entry.name in names:
            for label, text in {"topic": entry.topic, **entry.notes}.items():
                yield _WRAPPER.fill(f"  {label}: {text}")


@command
def lsp_command() -> int:
    """Run the language server for editors, over standard input and output."""
    from facetlog.commands.model.scenes import list_builder_sizes
    from facetlog.grammar.language_server import run

    run(list_builder_sizes())
    return YES
