"""What `model draw` and `model sample` share: which model is meant, and what none meets."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.errors import InputError

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis
    from facetlog.prototype.search import Search
    from facetlog.prototype.workbench import Workbench

__all__ = ["EFFORT", "Effort", "ModelName", "conflict_lines", "model_errors", "workbench"]

EFFORT = 240
"""Solids that are tried, if no other number is given: some two minutes where none holds."""

ModelName = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="A model that comes with facetlog or is in --models, or a .model file that has one.",
        show_default=False,
    ),
]
Effort = Annotated[
    int, typer.Option("--effort", metavar="N", min=1, help="So many solids are tried at most.")
]

SUFFIX = ".model"


def model_errors(name: str, models: list[Path]) -> str:
    """The errors of the files in the model language among those that are meant, as text."""
    from facetlog.commands.model.check import checked
    from facetlog.commands.model.fault_text import distinct, faults_text
    from facetlog.grammar.faults import Severity
    from facetlog.kb.recognize import rule_files

    files = [path for path in rule_files(_files(name, models)) if path.suffix == SUFFIX]
    looks = [checked(path) for path in files]
    for analysis, _ in looks:
        _is_of_one_thing(analysis, name)
    faults = distinct(fault for _, found in looks for fault in found)
    errors = [fault for fault in faults if fault.severity is Severity.ERROR]
    return faults_text(files, errors) if errors else ""


def _is_of_one_thing(analysis: "Analysis", name: str) -> None:
    """Raises InputError if the model that is meant is made of several things."""
    own = Path(name).name == Path(analysis.file.source.name).name
    for model in analysis.models:
        scope = analysis.scopes.get(model)
        if (own or model == name) and scope is not None and scope.of_things:
            raise InputError(f"{model} is made of several things: what is drawn is one solid")


def _files(name: str, models: list[Path]) -> list[Path]:
    return [*models, *([Path(name)] if name.endswith(SUFFIX) else [])]


@contextmanager
def workbench(name: str, models: list[Path], *, trust: bool) -> "Iterator[Workbench]":
    """Where solids are judged by the model that is meant; InputError if it is not clear which."""
    from facetlog.kb.recognize import open_knowledge_base
    from facetlog.prototype.workbench import Workbench

    with open_knowledge_base(_files(name, models), trusted=trust) as base:
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
        yield Workbench(base, name)


def conflict_lines(search: "Search") -> Iterator[str]:
    """What no solid met together, where it stands, and what to do."""
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
    for line in best.judged.verdict.miss_lines():
        yield f"  {line}"
