"""True labels of scenes from a table, and how they count."""

import csv
import io
import os
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.shapes.shape_options import UP_AXES
from facetlog.plurals import many
from facetlog.safe_read import read_regular_text

NONE = "none"
"""The answer that no model of those asked for holds, and the truth of what is none of them."""

ERROR = "error"
"""The answer of a scene that has none."""

SEPARATORS = ",;\t"

LETTERS = 2
"""By which a label may be longer or shorter than the model that was meant: typing errors."""

NAMED = 5
"""Labels that are named where many are no models."""


@dataclass(frozen=True, slots=True)
class Label:
    """One line of a table of labels; `up` and `unit` where it says so, as options of classify."""

    file: str
    label: str
    up: str | None = None
    unit: str | None = None
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Truth:
    """Right answer for a label: `answer` is right; one of `doubtful` neither right nor wrong.

    A label that is not counted at all has no answer.
    """

    answer: str | None
    doubtful: frozenset[str] = frozenset()


def read_labels(path: Path) -> dict[str, Label]:
    """Return the labels by the real path of their file, which is relative to the table's folder.

    A CSV with the columns file and label; up_axis, units and kind may be there as well. Of the
    former two the first word counts: an axis or a unit is taken, any other word ('unknown') means
    that it is not known, and an empty cell leaves it to the options. Semicolons or tabs may
    separate cells, as spreadsheets of some countries write them. Raise InputError for a table that
    cannot be read, lacks a column, has a file twice, or a line without file or label.
    """
    try:
        text = read_regular_text(path)
        head = text.partition("\n")[0]
        between = max(SEPARATORS, key=head.count)
        lines = csv.DictReader(io.StringIO(text, newline=""), delimiter=between, strict=True)
        missing = {"file", "label"} - set(lines.fieldnames or ())
        if missing:
            raise InputError(f"{path}: lacks the column {' and '.join(sorted(missing))}")
        found: dict[str, Label] = {}
        for line in lines:
            where = f"{path}:{lines.line_num}"
            if None in line:
                raise InputError(f"{where}: has more cells than there are columns: quote commas")
            label = _label(path, line)
            for name in ("file", "label"):
                if not (line[name] or "").strip():
                    raise InputError(f"{where}: has no {name}: give it, or leave the line out")
            if found.setdefault(os.path.realpath(label.file), label) is not label:
                raise InputError(f"{where}: {line['file']} is there twice")
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror or exc}") from exc
    except csv.Error as exc:
        raise InputError(
            f"{path}:{lines.line_num}: is no line of a CSV: {exc}: close quotes, and double those "
            "within"
        ) from exc
    except UnicodeDecodeError as exc:
        raise InputError(f"{path}: is no UTF-8 text: {exc}: save it as UTF-8") from exc
    return found


def _label(path: Path, line: Mapping[str, str | None]) -> Label:
    def cell(name: str) -> str:
        return (line.get(name) or "").strip()

    return Label(
        str(path.parent / cell("file")),
        cell("label"),
        _first_word(cell("up_axis"), UP_AXES),
        _first_word(cell("units"), METRES_PER),
        cell("kind"),
    )


def _first_word(text: str, known: Mapping[str, object]) -> str | None:
    """Return the word if it is known, 'none' for another, None for an empty cell.

    >>> [_first_word(text, {"z": 1}) for text in ("z (from table plane)", "unknown", "")]
    ['z', 'none', None]
    """
    words = text.lower().split()
    if not words:
        return None
    return words[0] if words[0] in known else "none"


def check_model_names(models: Iterable[str]) -> None:
    """Raise InputError for a model whose name is what no answer and an error are called."""
    # Loaded only now: it takes 80 ms, and built-in models are called nothing else.
    from facetlog.grammar.checking.model import RESERVED_NAMES

    for name in models:
        if name in RESERVED_NAMES:
            raise InputError(f"a model is called {name}, which results say of no model: rename it")


def iter_unknown_labels(
    labels: Iterable[str], models: Collection[str], counted_as: Mapping[str, Truth]
) -> Iterator[str]:
    """Say which labels are no models, and so count as none: with the model that is meant, if any.

    >>> list(iter_unknown_labels(["bxo", "lamp", "box"], ["box"], {}))  # doctest: +ELLIPSIS
    ["label 'bxo' is no model: did you mean box? It counts as none", '1 other label ... none: lamp']
    """
    from facetlog.query_shell.words import nearest  # loaded on demand

    strange = [label for label in dict.fromkeys(labels) if label not in (*models, NONE)]
    others = []
    for label in strange:
        if label in counted_as:
            continue
        meant = nearest(label.lower(), models)
        if meant is not None and abs(len(meant) - len(label)) <= LETTERS:
            yield f"label {label!r} is no model: did you mean {meant}? It counts as none"
        else:
            others.append(label)
    if others:
        named = ", ".join(others[:NAMED]) + (", …" if len(others) > NAMED else "")
        count = many(len(others), "other label is no model", "other labels are no models")
        yield f"{count} and counted as none: {named}"


def parse_class_names(names: str, models: Collection[str]) -> tuple[str, ...]:
    """Return the models that a text like 'chair, box' names; InputError for one that is none.

    >>> parse_class_names("chair, box,", ["box", "table", "chair"])
    ('chair', 'box')
    """
    named = tuple(dict.fromkeys(filter(None, map(str.strip, names.split(",")))))
    for name in named:
        if name not in models:
            raise InputError(f"--classes: {name} is no model; there are {', '.join(models)}")
    return named


def find_labelled_classes(
    models: Iterable[str], labels: Iterable[Label], counted_as: Mapping[str, Truth]
) -> tuple[str, ...]:
    """Return the models, in their order, that are labels, or that a label counts as.

    Raise InputError if there are labels, and no model is one: any answer would be none.
    """
    models, labels = tuple(models), tuple(labels)
    truths = counted_as.values()
    named = {label.label for label in labels}.union(
        *(truth.doubtful for truth in truths), (truth.answer for truth in truths)
    )
    found = tuple(model for model in models if model in named)
    if labels and not found:
        raise InputError(
            f"--labels: no label is the name of a model ({', '.join(models)}): say by --classes "
            "which of them can be the answer"
        )
    return found


def truths(counted_as: Sequence[str], classes: Collection[str]) -> dict[str, Truth]:
    """Return how labels count that are not called as their class, from texts like 'armchair=chair'.

    'desk=' leaves a label out. 'cabinet=none|box' says that none is right, and box neither right
    nor wrong. A label need not occur: one list of them serves many tables. Raise InputError for
    another text, and for a class that is none of `classes`.

    >>> truths(["armchair=chair"], ["chair"])["armchair"].answer
    'chair'
    """
    found: dict[str, Truth] = {}
    for text in counted_as:
        label, equals, answers = text.partition("=")
        if not (label and equals):
            raise InputError(f"--count-as {text}: write LABEL=CLASS, LABEL=CLASS|CLASS or LABEL=")
        named = [name.strip() for name in answers.split("|") if name.strip()]
        for name in named:
            if name not in (*classes, NONE):
                known = ", ".join((*classes, NONE))
                raise InputError(f"--count-as {text}: {name} is none of the classes {known}")
        found[label] = Truth(named[0] if named else None, frozenset(named[1:]))
    return found
