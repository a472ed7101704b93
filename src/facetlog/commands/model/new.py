"""`facetlog model new`: a file to start from."""

from pathlib import Path
from string import Template
from typing import Annotated

import typer

from facetlog.commands.shared import YES, command
from facetlog.errors import InputError
from facetlog.terminal import one_line

__all__ = ["TEMPLATE", "new_command"]

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

  # Examples are tests. `from "scene.json"` takes a scene that `facetlog reconstruct` wrote.
  example "dining table" of table(width 80 cm, length 140 cm, height 74 cm) holds
  example "closed block" of cuboid(width 80 cm, depth 80 cm, height 74 cm) fails because top
"""
)


@command
def new_command(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="What the model is called, or NAME.model.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="The file; NAME.model if not given."),
    ] = None,
) -> int:
    """Writes a model to start from, which passes its check and its examples as it stands."""
    from facetlog.grammar.analysis import analyse

    # As people write it: the name of the file.
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
    typer.echo(one_line(str(path)))
    return YES


def _write_new(path: Path, text: str) -> None:
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f"{path} is there already: give another name, or -o FILE") from None
    except OSError as exc:
        raise InputError(f"{path} cannot be written: {exc.strerror}") from exc
