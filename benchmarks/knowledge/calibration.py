"""When a model gives a degree, how often is it right: as the degree stands, and calibrated?

Every model is asked about the main thing of labelled scenes: tours of 6 to 24 pictures through
rendered worlds, and under FACETLOG_DATA the shapes and the path-traced pictures of some of them.
What each source (a world, a collection of shapes) is told is fitted to all others. Wanted of
verdicts that hold: by model a difference of 0.05 at most between what was said and what was true.

    python -m benchmarks.knowledge.calibration --fit            writes kb/calibration.json
    python -m benchmarks.knowledge.calibration --rows FILE      keeps the verdicts, or takes kept
                                                                ones: then a fit takes seconds
    python -m benchmarks.knowledge.calibration --picture FILE   draws the reliability diagram
"""

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.common import (
    Report,
    Row,
    Settings,
    Table,
    find_data_set,
    make_settings_parser,
    text,
)
from benchmarks.knowledge.calibration_scenes import (
    KINDS,
    LabelledScene,
    iter_picture_scenes,
    iter_shape_scenes,
    load_tour_scene,
    truth,
)
from facetlog.kb.batch_judge import BatchJudge, collect_columns, collect_evidence
from facetlog.kb.calibration import (
    FEATURES,
    SHIPPED,
    Calibration,
    Evidence,
    InputKind,
    load_shipped_calibration,
)
from facetlog.kb.calibration_fit import (
    Sample,
    build_reliability_table,
    compute_calibration_error,
    compute_error_by_model,
    fit,
    held_out,
    read_samples,
    write_samples,
)
from facetlog.kb.confidence import Confidence
from facetlog.kb.engine.engine import house
from facetlog.kb.explaining.proof import State
from facetlog.kb.limits import Limits

NAME = "calibration"
# Of each world of the tours.
SEEDS = 3
ALL = "all"
# Of one scene, on a machine that is kept busy.
PATIENCE_S = 600.0
# Then the mean is known to a hundredth of itself.
CHANCE_DRAWS = 1000


def judged(scenes: Iterable[LabelledScene]) -> tuple[Sample, ...]:
    """Return what every built-in model says of the main thing of each scene; nothing where people
    would not agree whether the thing is of the model's kind."""
    samples = []
    with BatchJudge(limits=Limits(seconds=PATIENCE_S)) as judge:
        for scene in scenes:
            if scene.thing is None:
                continue
            columns = collect_columns(scene.facts)
            evidence = collect_evidence(columns).get(scene.thing, Evidence(InputKind.PICTURES))
            for verdict in judge.judge_columns(columns):
                true = truth(scene, verdict.model)
                if verdict.thing == scene.thing and true is not None:
                    samples.append(
                        Sample(
                            verdict.model,
                            judge.judging_keys[verdict.model],
                            evidence.kind,
                            scene.source,
                            verdict.state,
                            verdict.degree,
                            verdict.degree_at_most,
                            true,
                            evidence.views,
                            evidence.seen,
                        )
                    )
    return tuple(samples)


def measure(settings: Settings) -> Report:
    """Measure each source checked by maps that were fitted to the others."""
    return report(settings, judged(_scenes(settings)))


def _scenes(settings: Settings) -> Iterator[LabelledScene]:
    for seed in settings.seeds(SEEDS):
        for world in KINDS:
            print(f"  {world} {seed}    ", end="\r", file=sys.stderr, flush=True)
            yield load_tour_scene(world, seed)
    for name, scenes in (("shapes", iter_shape_scenes), ("pictures", iter_picture_scenes)):
        folder = find_data_set(name)
        if isinstance(folder, Path):
            print(f"  {name}            ", end="\r", file=sys.stderr, flush=True)
            yield from scenes(folder)


def report(settings: Settings, samples: Sequence[Sample]) -> Report:
    """Return how far degrees and confidences are off."""
    found = held_out(samples)
    raw = [s.score for s in samples]
    said = [score if c.value is None else c.value for score, c in zip(raw, found, strict=True)]
    same = fit(samples) == load_shipped_calibration()
    every = range(len(samples))
    held = [i for i in every if samples[i].state is State.HOLDS]
    kinds = [kind for kind in InputKind if any(s.kind is kind for s in samples)]
    groups = [(ALL, list(every))]
    groups += [(kind.value, [i for i in every if samples[i].kind is kind]) for kind in kinds]
    groups += [("verdicts that hold", held)]
    groups += [
        (f"{kind.value}, that hold", [i for i in held if samples[i].kind is kind]) for kind in kinds
    ]
    truths = [s.truth for s in samples]
    return Report(
        NAME,
        (
            Table("Sources", _source_rows(samples)),
            Table(
                "Expected calibration error (10 bins) and Brier score, raw and calibrated",
                tuple(_error_row(name, some, raw, said, truths) for name, some in groups if some),
            ),
            Table("By model, verdicts that hold", tuple(_model_rows(samples, found, held))),
            Table(
                "Degrees, verdicts that hold",
                _reliability_rows([raw[i] for i in held], [truths[i] for i in held]),
            ),
            Table(
                "Calibrated, verdicts that hold",
                _reliability_rows([said[i] for i in held], [truths[i] for i in held]),
            ),
            Table("Weights of the evidence, log odds", _weight_rows(samples)),
        ),
        {
            "pairs of thing and model": len(samples),
            "sources": len({s.source for s in samples}),
            "first seed": settings.first,
        },
        (
            "Scenes in which nothing was found have no samples.",
            "By chance: the error that so few verdicts show of probabilities exactly right.",
            "As shown: bounds in place of a figure where few cases are known; what lies within "
            "them is no error.",
            "The shipped calibration is the one fitted to all of these."
            if same
            else "The shipped calibration is another one: --fit writes this one.",
        ),
    )


def _model_rows(
    samples: Sequence[Sample], found: Sequence[Confidence], held: Sequence[int]
) -> Iterator[Row]:
    """Yield for each model, and for all, what was said of each source by the others, the share that
    was true, and the error: of the values, and of what is shown."""
    models = sorted({samples[i].model for i in held})
    for name in (ALL, *models):
        some = [i for i in held if name in (ALL, samples[i].model)]
        chosen = [samples[i] for i in some]
        shown = [found[i] for i in some]
        values = [Confidence(one.value) for one in shown]
        said = np.array([one.value or 0.0 for one in shown])
        yield {
            "model": name,
            "verdicts": len(some),
            "true": round(float(np.mean([s.truth for s in chosen])), 4),
            "said": round(float(said.mean()), 4),
            "low": round(float(np.mean([one.low or 0.0 for one in shown])), 4),
            "high": round(float(np.mean([one.high or 0.0 for one in shown])), 4),
            "few": sum(one.is_wide for one in shown),
            "error": round(compute_error_by_model(chosen, values), 4),
            "by chance": round(_estimate_chance_by_model(chosen, said), 4),
            "as shown": round(compute_error_by_model(chosen, shown), 4),
        }


def _estimate_chance_by_model(samples: Sequence[Sample], said: np.ndarray) -> float:
    """Return `compute_error_by_model` that so few samples show of values exactly right."""
    rng = np.random.default_rng(0)
    models = np.unique([s.model for s in samples], return_inverse=True)[1]
    drawn = rng.random((CHANCE_DRAWS, said.size)) < said
    off = [np.abs(np.bincount(models, weights=said - one)).sum() for one in drawn]
    return float(np.mean(off)) / said.size


def _weight_rows(samples: Sequence[Sample]) -> tuple[Row, ...]:
    return tuple(
        {"state": state.value, **dict(zip(FEATURES, scale.weights, strict=True))}
        for state, scale in fit(samples).scales.items()
    )


def _source_rows(samples: Sequence[Sample]) -> tuple[Row, ...]:
    sources = dict.fromkeys((s.source, s.kind) for s in samples)
    return tuple(
        {
            "source": source,
            "kind": kind.value,
            "pairs": len(some),
            "true": sum(s.truth for s in some),
            "hold": sum(s.state is State.HOLDS for s in some),
            "hold and true": sum(s.state is State.HOLDS and s.truth for s in some),
        }
        for source, kind in sources
        if (some := [s for s in samples if (s.source, s.kind) == (source, kind)])
    )


def _error_row(
    name: str,
    chosen: Sequence[int],
    raw: Sequence[float],
    said: Sequence[float],
    truths: Sequence[bool],
) -> Row:
    before, after, true = ([values[i] for i in chosen] for values in (raw, said, truths))
    right = [bool(t) for t in true]
    return {
        "of": name,
        "pairs": len(chosen),
        "true": sum(right),
        "ECE raw": round(compute_calibration_error(before, right), 4),
        "ECE calibrated": round(compute_calibration_error(after, right), 4),
        "by chance": round(estimate_chance_error(after), 4),
        "Brier raw": round(_brier(before, right), 4),
        "Brier calibrated": round(_brier(after, right), 4),
    }


def _reliability_rows(said: Sequence[float], truths: Sequence[bool]) -> tuple[Row, ...]:
    return tuple(
        {
            "from": row.low,
            "to": row.high,
            "verdicts": row.count,
            "said": round(row.said, 4),
            "true": round(row.true, 4),
        }
        for row in build_reliability_table(said, truths)
    )


def estimate_chance_error(said: Sequence[float]) -> float:
    """Return the expected calibration error that so few samples show of a forecast that is exactly
    right.

    The mean over truths drawn from what was said; the draws are always the same.
    """
    rng = np.random.default_rng(0)
    forecast = np.array(said)
    drawn = (rng.random(forecast.size) < forecast for _ in range(CHANCE_DRAWS))
    errors = [_error(forecast, truths) for truths in drawn]
    return float(np.mean(errors))


def _error(said: np.ndarray, truths: np.ndarray, bins: int = 10) -> float:
    """Return `compute_calibration_error`, of arrays."""
    number = np.minimum((said * bins).astype(int), bins - 1)
    off = np.bincount(number, weights=said - truths, minlength=bins)
    return float(np.abs(off).sum() / said.size)


def _brier(said: Sequence[float], truths: Sequence[bool]) -> float:
    """Return the mean squared error; a calibrated forecast that tells nothing apart still has a
    large one.

    0 without any.
    """
    errors = [(p - t) ** 2 for p, t in zip(said, truths, strict=True)]
    return sum(errors) / len(errors) if errors else 0.0


def draw(path: Path, samples: Sequence[Sample]) -> None:
    """Write the reliability diagram as SVG: what was said against what was true, of all verdicts
    and of those that hold, as degrees stand and calibrated, each source by maps of the others.

    Areas of dots grow with the verdicts.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    forecasts = (
        ("degree", [s.score for s in samples], "#b04a3a"),
        ("confidence", [c.value or 0.0 for c in held_out(samples)], "#2a6f97"),
    )
    every = range(len(samples))
    panels = (
        ("All verdicts", every),
        ("Verdicts that hold", [i for i in every if samples[i].state is State.HOLDS]),
    )
    with mpl.rc_context({"svg.hashsalt": "facetlog", "font.size": 9}):
        figure = Figure(figsize=(7.6, 4.6), layout="constrained")
        for axes, (title, chosen) in zip(figure.subplots(1, 2), panels, strict=True):
            truths = [samples[i].truth for i in chosen]
            axes.plot((0, 100), (0, 100), color="0.7", lw=1, zorder=0)
            for name, every_said, colour in forecasts:
                said = [every_said[i] for i in chosen]
                rows = build_reliability_table(said, truths)
                error = compute_calibration_error(said, truths)
                at, true = [100 * r.said for r in rows], [100 * r.true for r in rows]
                label = f"{name}: off by {error:.3f} in the mean"
                axes.plot(at, true, "-", color=colour, lw=1, label=label)
                sizes = [6 + 2 * r.count**0.5 for r in rows]
                axes.scatter(at, true, s=sizes, color=colour, zorder=2)
            axes.set(
                xlim=(-2, 102), ylim=(-2, 102), aspect="equal", title=f"{title}: {len(truths)}"
            )
            axes.set(xlabel="said, %", ylabel="true, %")
            axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.15))
        figure.savefig(path, metadata={"Date": None}, format="svg")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the report, and with --fit keep the maps."""
    parser = make_settings_parser(
        f"python -m benchmarks.knowledge.{NAME}", (__doc__ or "").split("\n\n")[0]
    )
    parser.add_argument("--fit", action="store_true", help=f"write kb/{SHIPPED}")
    parser.add_argument("--rows", metavar="FILE", help="keep the verdicts, or take kept ones")
    parser.add_argument("--picture", metavar="FILE", help="draw the reliability diagram")
    given = parser.parse_args(arguments)
    settings = Settings(given.seeds, given.first_seed)
    kept = Path(given.rows) if given.rows else None
    if kept is not None and kept.exists():
        samples = read_samples(kept)
    else:
        samples = judged(_scenes(settings))
        if kept is not None:
            write_samples(kept, samples)
    if given.fit:
        write(fit(samples), house("kb") / SHIPPED)
    if given.picture:
        draw(Path(given.picture), samples)
    data = report(settings, samples).to_json()
    print(json.dumps(data) if given.json else "\n".join(text(data)))


def write(calibration: Calibration, path: Path) -> None:
    """Keep the calibration as JSON, each model on a line."""
    path.write_text(_indented(calibration.to_json()) + "\n", encoding="utf-8")


def _indented(data: object, depth: int = 0) -> str:
    """Return JSON, each entry of an object on a line of its own, but models whole."""
    if not isinstance(data, dict) or "content" in data:
        return json.dumps(data)
    pad = " " * (depth + 1)
    entries = [f"{pad}{json.dumps(k)}: {_indented(v, depth + 1)}" for k, v in data.items()]
    return "{\n" + ",\n".join(entries) + "\n" + " " * depth + "}" if entries else "{}"


if __name__ == "__main__":
    main(None)
