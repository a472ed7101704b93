"""When a model gives a degree, how often is it right: as the degree stands, and calibrated?

Every model is asked about the main thing of labelled scenes: tours of 24 pictures through rendered
worlds, and the shapes under FACETLOG_DATA, the half that rules are developed on. The maps of
kb/calibration.py are checked on each source (a world, a collection of shapes) by maps that were
fitted to all others. Wanted: an expected calibration error of 0.04 at most, and of verdicts that
hold 0.10.

    python -m benchmarks.knowledge.calibration --fit            writes kb/calibration.json
    python -m benchmarks.knowledge.calibration --picture FILE   draws the reliability diagram
"""

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
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
    iter_shape_scenes,
    load_tour_scene,
    truth,
)
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.calibration import SHIPPED, Calibration, InputKind, load_shipped_calibration
from facetlog.kb.calibration_fit import (
    Sample,
    build_reliability_table,
    choose_form,
    compute_calibration_error,
    fit,
    held_out,
)
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


@dataclass(frozen=True, slots=True)
class Judged:
    """What the models said of the main things of some scenes, and the models' judging keys.

    Where people would not agree whether a thing is of a model's kind, there is no sample.
    """

    scenes: int
    samples: tuple[Sample, ...]
    judging_keys: tuple[tuple[str, str], ...]


def judged(scenes: Iterable[LabelledScene]) -> Judged:
    """Return what every built-in model says of the main thing of each scene."""
    count, samples = 0, []
    with BatchJudge(limits=Limits(seconds=PATIENCE_S)) as judge:
        for scene in scenes:
            count += 1
            if scene.thing is None:
                continue
            for verdict in judge.judge(scene.facts):
                true = truth(scene, verdict.model)
                if verdict.thing == scene.thing and true is not None:
                    low, high = verdict.degree, verdict.degree_at_most
                    samples.append(
                        Sample(
                            verdict.model, scene.kind, scene.source, verdict.state, low, high, true
                        )
                    )
        return Judged(count, tuple(samples), tuple(judge.judging_keys.items()))


def measure(settings: Settings) -> Report:
    """Measure each source checked by maps that were fitted to the others."""
    return report(settings, judged(_scenes(settings)))


def _scenes(settings: Settings) -> Iterator[LabelledScene]:
    for seed in settings.seeds(SEEDS):
        for world in KINDS:
            print(f"  {world} {seed}    ", end="\r", file=sys.stderr, flush=True)
            yield load_tour_scene(world, seed)
    folder = find_data_set("shapes")
    if isinstance(folder, Path):
        yield from iter_shape_scenes(folder)


def report(settings: Settings, found: Judged) -> Report:
    """Return how far degrees and confidences are off."""
    samples, keys = found.samples, dict(found.judging_keys)
    said = held_out(samples, keys)
    same = fit(samples, keys) == load_shipped_calibration()
    every = range(len(samples))
    held = [i for i in every if samples[i].state is State.HOLDS]
    kinds = [kind for kind in InputKind if any(s.kind is kind for s in samples)]
    groups = [(ALL, list(every))]
    groups += [(kind.value, [i for i in every if samples[i].kind is kind]) for kind in kinds]
    groups += [("verdicts that hold", held)]
    groups += [
        (f"{kind.value}, that hold", [i for i in held if samples[i].kind is kind]) for kind in kinds
    ]
    groups += [(model, [i for i in every if samples[i].model == model]) for model in keys]
    raw = [s.score for s in samples]
    truths = [s.truth for s in samples]
    return Report(
        NAME,
        (
            Table("Sources", _source_rows(samples)),
            Table(
                "Expected calibration error (10 bins) and Brier score, raw and calibrated",
                tuple(_error_row(name, some, raw, said, truths) for name, some in groups if some),
            ),
            Table("Degrees as they stand", _reliability_rows(raw, truths)),
            Table("Calibrated, each source by maps of the others", _reliability_rows(said, truths)),
            Table(
                "Calibrated, verdicts that hold",
                _reliability_rows([said[i] for i in held], [truths[i] for i in held]),
            ),
            Table("Maps by state, as fitted to all sources", _form_rows(samples)),
        ),
        {
            "scenes": found.scenes,
            "pairs of scene and model": len(samples),
            "sources": len({s.source for s in samples}),
            "first seed": settings.first,
            "views of a tour": 24,
        },
        (
            "Scenes in which nothing was found have no samples.",
            "By chance: the error that so few verdicts show of probabilities exactly right.",
            "The shipped calibration is the one fitted to all of these."
            if same
            else "The shipped calibration is another one: --fit writes this one.",
        ),
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


def _form_rows(samples: Sequence[Sample]) -> tuple[Row, ...]:
    states = [[s for s in samples if s.state is state] for state in State]
    return tuple(
        {
            "state": some[0].state.value,
            "pairs": len(some),
            "sources": len({s.source for s in some}),
            "shape": "rising" if form.rising else "flat",
            "strength": form.strength,
        }
        for some in states
        if some
        for form in [choose_form(some)]
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


def draw(path: Path, found: Judged) -> None:
    """Write the reliability diagram as SVG: what was said against what was true, of all verdicts
    and of those that hold, as degrees stand and calibrated, each source by maps of the others.

    Areas of dots grow with the verdicts.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    samples = found.samples
    forecasts = (
        ("degree", [s.score for s in samples], "#b04a3a"),
        ("confidence", held_out(samples, dict(found.judging_keys)), "#2a6f97"),
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
    parser.add_argument("--picture", metavar="FILE", help="draw the reliability diagram")
    given = parser.parse_args(arguments)
    settings = Settings(given.seeds, given.first_seed)
    found = judged(_scenes(settings))
    if given.fit:
        write(fit(found.samples, dict(found.judging_keys)), house("kb") / SHIPPED)
    if given.picture:
        draw(Path(given.picture), found)
    data = report(settings, found).to_json()
    print(json.dumps(data) if given.json else "\n".join(text(data)))


def write(calibration: Calibration, path: Path) -> None:
    """Keep the maps as JSON, each map on a line."""
    path.write_text(_indented(calibration.to_json()) + "\n", encoding="utf-8")


def _indented(data: object, depth: int = 0) -> str:
    """Return JSON, each entry of an object on a line of its own, but maps whole."""
    if not isinstance(data, dict) or "knots" in data:
        return json.dumps(data)
    pad = " " * (depth + 1)
    entries = [f"{pad}{json.dumps(k)}: {_indented(v, depth + 1)}" for k, v in data.items()]
    return "{\n" + ",\n".join(entries) + "\n" + " " * depth + "}" if entries else "{}"


if __name__ == "__main__":
    main(None)
