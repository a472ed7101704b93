"""When a model gives a degree, how often is it right: as the degree stands, and calibrated?

Tours of 24 pictures through worlds of all kinds are rendered and reconstructed, and every model is
asked about the main thing of each. The maps of kb/calibration.py are fitted to some seeds and
checked on others. Wanted: an expected calibration error of 0.03 at most on the latter.

    python -m benchmarks.calibration --fit     writes kb/calibration.json
"""

import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.calibration_scenes import KINDS, TourScene, tour_scene, truth
from benchmarks.common import Report, Row, Settings, Table, settings_parser, text
from facetlog.kb.calibration import (
    SHIPPED,
    Calibration,
    Sample,
    expected_calibration_error,
    fit,
    reliability_table,
    shipped_calibration,
)
from facetlog.kb.engine.engine import house
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase

__all__ = ["NAME", "Judged", "chance_error", "fitted", "judged", "main", "measure", "report"]

NAME = "calibration"
# Seeds of each world: to fit, and to check; far apart, so that no count makes them meet.
FIT_SEEDS = 10
CHECK_SEEDS = 7
FIRST_TO_CHECK = 1000
ALL = "all"
# Then the mean is known to a hundredth of itself.
CHANCE_DRAWS = 1000


@dataclass(frozen=True, slots=True)
class Judged:
    """What the models said of the main things of some scenes, and the contents of the models.

    Where people would not agree whether a thing is of a model's kind, there is no sample.
    """

    scenes: tuple[TourScene, ...]
    samples: tuple[Sample, ...]
    holding: tuple[tuple[str, str], ...]
    contents: tuple[tuple[str, str], ...]


def judged(scenes: Iterable[TourScene]) -> Judged:
    """What every built-in model says of the main thing of each scene."""
    kept, samples, holding = [], [], []
    with KnowledgeBase() as base:
        for scene in scenes:
            kept.append(scene)
            if scene.thing is None:
                continue
            base.load_scene("scene", scene.facts)
            for model in base.models:
                verdict = base.judge("scene", model, scene.thing)
                if verdict.state is State.HOLDS:
                    holding.append((scene.world, model))
                true = truth(scene.world, model)
                if true is not None:
                    low, high = verdict.degree, verdict.degree_at_most
                    samples.append(Sample(model, verdict.state, low, high, true))
        contents = tuple((model, rules.content) for model, rules in base.models.items())
    return Judged(tuple(kept), tuple(samples), tuple(holding), contents)


def fitted(found: Judged) -> Calibration:
    """The calibration of all models from these samples."""
    return fit(found.samples, dict(found.contents))


def measure(settings: Settings) -> Report:
    """Fits to seeds of its own, and checks on the seeds of the settings."""
    return _measured(settings)[0]


def _measured(settings: Settings) -> tuple[Report, Calibration]:
    to_fit = judged(_scenes(range(FIT_SEEDS)))
    seeds = (FIRST_TO_CHECK + seed for seed in settings.seeds(CHECK_SEEDS))
    to_check = judged(_scenes(seeds))
    calibration = fitted(to_fit)
    return report(settings, to_fit, to_check, calibration), calibration


def _scenes(seeds: Iterable[int]) -> Iterable[TourScene]:
    for seed in seeds:
        for world in KINDS:
            print(f"  {world} {seed}    ", end="\r", file=sys.stderr, flush=True)
            yield tour_scene(world, seed)


def report(
    settings: Settings, to_fit: Judged, to_check: Judged, calibration: Calibration
) -> Report:
    """How the calibration of the first does on the second."""
    models = [model for model, _ in to_check.contents]
    samples = to_check.samples
    before = [sample.score for sample in samples]
    after = [_calibrated(calibration, sample) for sample in samples]
    same = calibration == shipped_calibration()
    return Report(
        NAME,
        (
            Table("What holds of the things that were checked", _world_rows(to_check)),
            Table(
                "Expected calibration error (10 bins) and Brier score, before and after",
                tuple(
                    _error_row(model, to_fit.samples, samples, calibration)
                    for model in (*models, ALL)
                ),
            ),
            Table("Degrees as they stand", _reliability_rows(before, samples)),
            Table("Calibrated", _reliability_rows(after, samples)),
        ),
        {
            "worlds": len(KINDS),
            "scenes to fit": len(to_fit.scenes),
            "scenes to check": len(to_check.scenes),
            "first seed to check": FIRST_TO_CHECK + settings.first,
            "views": 24,
        },
        (
            "No seed is used for both. Scenes in which nothing was found have no samples.",
            "By chance: the error that so few verdicts show of probabilities exactly right.",
            "The shipped calibration is this one."
            if same
            else "The shipped calibration is another one: --fit writes this one.",
        ),
    )


def _world_rows(found: Judged) -> tuple[Row, ...]:
    holding = Counter(found.holding)
    models = [model for model, _ in found.contents]
    return tuple(
        {
            "world": world,
            "is": ", ".join(sorted(KINDS[world])) or None,
            "scenes": len(scenes),
            "things": sum(scene.thing is not None for scene in scenes),
            **{model: holding[world, model] for model in models},
        }
        for world in KINDS
        if (scenes := [scene for scene in found.scenes if scene.world == world])
    )


def _error_row(
    model: str, to_fit: Sequence[Sample], to_check: Sequence[Sample], calibration: Calibration
) -> Row:
    chosen = [s for s in to_check if model in (ALL, s.model)]
    truths = [s.truth for s in chosen]
    before = [s.score for s in chosen]
    after = [_calibrated(calibration, s) for s in chosen]
    return {
        "model": model,
        "fitted to": sum(model in (ALL, s.model) for s in to_fit),
        "checked on": len(chosen),
        "of its kind": sum(truths),
        "ECE before": round(expected_calibration_error(before, truths), 4),
        "ECE after": round(expected_calibration_error(after, truths), 4),
        "by chance": round(chance_error(after), 4),
        "Brier before": round(_brier(before, truths), 4),
        "Brier after": round(_brier(after, truths), 4),
    }


def _reliability_rows(said: Sequence[float], samples: Sequence[Sample]) -> tuple[Row, ...]:
    return tuple(
        {
            "from": row.low,
            "to": row.high,
            "verdicts": row.count,
            "said": round(row.said, 4),
            "true": round(row.true, 4),
        }
        for row in reliability_table(said, [s.truth for s in samples])
    )


def _calibrated(calibration: Calibration, sample: Sample) -> float:
    """The probability of a verdict; its degree as it stands if its model had no samples."""
    said = calibration.probability(sample.model, sample.low, sample.high)
    return sample.score if said is None else said


def chance_error(said: Sequence[float]) -> float:
    """The expected calibration error that so few samples show of a forecast that is exactly right.

    The mean over truths drawn from what was said; the draws are always the same.
    """
    rng = np.random.default_rng(0)
    forecast = np.array(said)
    drawn = (rng.random(forecast.size) < forecast for _ in range(CHANCE_DRAWS))
    errors = [expected_calibration_error(said, truths.tolist()) for truths in drawn]
    return float(np.mean(errors))


def _brier(said: Sequence[float], truths: Sequence[bool]) -> float:
    """The mean squared error; a calibrated forecast that tells nothing apart still has a large one.

    0 without any.
    """
    errors = [(p - t) ** 2 for p, t in zip(said, truths, strict=True)]
    return sum(errors) / len(errors) if errors else 0.0


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the report, and with --fit keeps the maps."""
    parser = settings_parser(f"python -m benchmarks.{NAME}", (__doc__ or "").split("\n\n")[0])
    parser.add_argument("--fit", action="store_true", help=f"write kb/{SHIPPED}")
    given = parser.parse_args(arguments)
    found, calibration = _measured(Settings(given.seeds, given.first_seed))
    if given.fit:
        write(calibration, house("kb") / SHIPPED)
    data = found.to_json()
    print(json.dumps(data) if given.json else "\n".join(text(data)))


def write(calibration: Calibration, path: Path) -> None:
    """Keeps the maps as JSON, a model's knots on a line each."""
    data = calibration.to_json()
    lines = [f'{{\n "schema": {json.dumps(data["schema"])},\n "models": {{']
    lines += [
        f"  {json.dumps(name)}: {json.dumps(model)}{',' * (i < len(data['models']))}"
        for i, (name, model) in enumerate(data["models"].items(), 1)
    ]
    path.write_text("\n".join([*lines, " }\n}\n"]), encoding="utf-8")


if __name__ == "__main__":
    main(None)
