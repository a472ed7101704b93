"""How often are chair, table, box and none of these answered right on meshes and clouds?

Third-party shapes under FACETLOG_DATA (shapes/labels.csv), and 200 of our own by seed. The answer
is the first of chair, table and box that holds, by degree. Listed apart and not counted: what is
borderline, and box where a plain cuboid may be one. The folder is split by the MD5 of the files'
names: rules are developed on one half, the other is held out. Intervals are Wilson's, 95 %.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.common import (
    Report,
    Row,
    Settings,
    Table,
    compute_median_and_spread,
    find_data_set,
    hash_tree,
)
from benchmarks.shapes.own_shapes import OWN_SHAPES, make_own_shape
from benchmarks.shapes.shape_judging import (
    NOISE_SHARE,
    SAMPLES,
    Judged,
    Task,
    confusion,
    is_held_out,
    judge_all,
)
from facetlog.batch.confusion import Confusion, Proportion
from facetlog.batch.labels import read_labels
from facetlog.perception.shapes.shape_options import UP_AXES

NAME = "accuracy_shapes"
SETS = (
    ("meshes", "Upright meshes"),
    ("clouds", "The same as clouds with noise"),
    ("own", "Our own meshes"),
)
SCANS = ("box", "cylindric_object")


def list_file_tasks(folder: Path) -> dict[str, list[Task]]:
    """Return the folder's upright meshes, the same as noisy clouds, and its scans of single
    things.
    """
    tasks: dict[str, list[Task]] = {"meshes": [], "clouds": [], "scans": []}
    for label in read_labels(folder / "labels.csv").values():
        name = Path(label.file).relative_to(folder).as_posix()
        if label.up not in UP_AXES:
            continue
        if label.kind == "mesh":
            tasks["meshes"].append(Task.of_file(label, name))
            tasks["clouds"].append(Task.of_file(label, name, sampled=True))
        elif label.label in SCANS:
            tasks["scans"].append(Task.of_file(label, name))
    return tasks


def list_own_tasks(seeds: Iterable[int]) -> list[Task]:
    """Return our own shapes of these seeds, in no unit."""
    return [
        Task(f"{seed} {make_own_shape(seed).name}", make_own_shape(seed).label, seed=seed)
        for seed in seeds
    ]


def _share(name: str, share: Proportion) -> Row:
    low, high = share.interval or (None, None)
    return {
        "of": name,
        "right": share.hits,
        "counted": share.of,
        "share": share.value,
        "95 % from": low,
        "to": high,
    }


def _shares(counted: Confusion) -> tuple[Row, ...]:
    rows = [_share("accuracy", counted.accuracy)]
    for name in counted.rows:
        rows.append(_share(f"recall of {name}", counted.recall(name)))
        rows.append(_share(f"precision of {name}", counted.precision(name)))
    return tuple(rows)


def _matrix(counted: Confusion) -> tuple[Row, ...]:
    return tuple(
        {"right": truth, **{given: counted.counts[truth, given] for given in counted.columns}}
        for truth in counted.rows
    )


def _mistakes(counted: Confusion) -> tuple[Row, ...]:
    return tuple(
        {
            "shape": mistake.path,
            "half": "held out" if is_held_out(mistake.path) else "development",
            "label": mistake.label,
            "answered": mistake.answered,
            "degree": None if mistake.degree is None else round(mistake.degree, 2),
            "error": mistake.error,
        }
        for mistake in counted.mistakes
    )


def _apart(counted: Confusion) -> tuple[Row, ...]:
    return tuple(
        {"label": label, "answered": given, "count": count}
        for (label, given), count in sorted(counted.left_out.items())
    )


def _tables(title: str, found: Sequence[Judged], *, halves: bool) -> list[Table]:
    counted = confusion(found)
    tables = [
        Table(f"{title}: right answers (rows) and answers given", _matrix(counted)),
        Table(f"{title}: all", _shares(counted)),
    ]
    if halves:
        for half, held_out in (("development half", False), ("held-out half", True)):
            some = (one for one in found if is_held_out(one.task.name) == held_out)
            tables.append(Table(f"{title}: {half}", _shares(confusion(some))))
    for what, rows in (("wrong", _mistakes(counted)), ("not counted", _apart(counted))):
        if rows:
            tables.append(Table(f"{title}: {what}", rows))
    return tables


def _scan_tables(found: Sequence[Judged]) -> list[Table]:
    """Return how many scans of boxes and of cylindric objects are answered box."""
    shares, wrong = [], []
    for label in SCANS:
        some = [one for one in found if one.task.label == label]
        said = [one for one in some if one.answered == "box"]
        shares.append(_share(f"{label} answered box", Proportion(len(said), len(some))))
        wrong += [one for one in some if (one.answered == "box") != (label == "box")]
    rows: tuple[Row, ...] = tuple(
        {
            "scan": one.task.name,
            "label": one.task.label,
            "answered": one.answered,
            "box is": ", ".join(v["state"] for v in one.row["verdicts"] if v["model"] == "box"),
        }
        for one in wrong
    )
    tables = [Table("Scans from one side", tuple(shares))]
    return [*tables, Table("Scans from one side: wrong", rows)] if rows else tables


def _seconds(found: Sequence[tuple[str, Sequence[Judged]]]) -> Table:
    return Table(
        "Seconds a shape, from file to answer",
        tuple(
            {"of": name, **compute_median_and_spread(one.seconds for one in some)}
            for name, some in found
        ),
    )


def measure(settings: Settings) -> Report:
    """Measure all tables; without the third-party data the benchmark is skipped."""
    folder = find_data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    tasks = list_file_tasks(folder) | {"own": list_own_tasks(settings.seeds(OWN_SHAPES))}
    every = judge_all([task for some in tasks.values() for task in some])
    found: dict[str, list[Judged]] = {name: [] for name in tasks}
    at = iter(every)
    for name, some in tasks.items():
        found[name] = [next(at) for _ in some]
    tables = [t for name, title in SETS for t in _tables(title, found[name], halves=name != "own")]
    tables += _scan_tables(found["scans"])
    tables.append(
        _seconds([(title, found[name]) for name, title in SETS] + [("Scans", found["scans"])])
    )
    return Report(
        NAME,
        tuple(tables),
        {
            "shapes": hash_tree(folder),
            "points of a cloud": SAMPLES,
            "noise, of the diagonal": NOISE_SHARE,
            "own shapes": len(tasks["own"]),
        },
        (
            "Wanted: meshes 0.93 accuracy, 0.90 recall and precision of each; clouds 0.90;",
            "scans of boxes 0.90 answered box, of cylindric objects none.",
        ),
    )
