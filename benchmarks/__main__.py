"""All benchmarks, or some of them: `python -m benchmarks [NAME …] [--seeds N] [--first-seed N]
[--json] [--write]`.

With --write each report is kept as benchmarks/results/NAME.json, and docs/benchmarks.md is made
anew from all reports that are kept there.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from benchmarks.common import Settings, settings_parser, text
from benchmarks.page import benchmarks_page

NAMES = (
    "accuracy_demo",
    "accuracy_no_box",
    "accuracy_pictures",
    "accuracy_worlds",
    "accuracy_faces",
    "accuracy_furniture",
    "accuracy_noise",
    "accuracy_drift",
    "accuracy_poses",
    "accuracy_front_end",
    "accuracy_grey_faces",
    "accuracy_junctions",
    "accuracy_estimation",
    "accuracy_online",
    "accuracy_explore",
    "accuracy_map",
    "accuracy_area",
    "accuracy_recursion",
    "accuracy_lines",
    "accuracy_planes",
    "accuracy_scans",
    "accuracy_shapes",
    "accuracy_prototypes",
    "accuracy_newcomer",
    "accuracy_plain",
    "accuracy_three_inputs",
    "time_demo",
    "time_large",
    "time_estimation",
    "time_facts",
    "time_facts_in",
    "time_answers_out",
    "time_box_rule",
    "time_growth",
    "time_reasons",
    "time_long_run",
    "time_stopping",
    "calibration",
    "time_models",
    "time_compiled",
    "time_mesh",
    "time_batch",
    "time_many_scenes",
    "fuzz_models",
)
HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
PAGE = HERE.parent / "docs" / "benchmarks.md"


def kept_reports() -> tuple[tuple[str, Mapping[str, object]], ...]:
    """The first paragraph of each benchmark's docstring and its report, of those kept."""
    kept = []
    for name in NAMES:
        path = RESULTS / f"{name}.json"
        if path.exists():
            question = (import_module(f"benchmarks.{name}").__doc__ or "").split("\n\n")[0]
            kept.append((question, json.loads(path.read_text(encoding="utf-8"))))
    return tuple(kept)


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs the benchmarks that are named, one after the other."""
    parser = settings_parser("python -m benchmarks", __doc__ or "")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--write", action="store_true", help="keep the reports, make the page")
    given = parser.parse_args(arguments)
    unknown = set(given.names) - set(NAMES)
    if unknown:
        parser.error(f"there is no benchmark {', '.join(sorted(unknown))}")
    settings = Settings(given.seeds, given.first_seed)
    for name in given.names or NAMES:
        print(f"{name} …", file=sys.stderr)
        report = import_module(f"benchmarks.{name}").measure(settings).to_json()
        print(json.dumps(report) if given.json else "\n".join((*text(report), "")), flush=True)
        if given.write and not report["skipped"]:
            RESULTS.mkdir(exist_ok=True)
            kept = json.dumps(report, indent=1, ensure_ascii=False)
            (RESULTS / f"{name}.json").write_text(kept + "\n", encoding="utf-8")
    if given.write:
        PAGE.write_text(benchmarks_page(kept_reports()), encoding="utf-8")


if __name__ == "__main__":
    main()
