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

MODULES = (
    "pictures.accuracy_demo",
    "pictures.accuracy_no_box",
    "pictures.accuracy_pictures",
    "pictures.accuracy_worlds",
    "pictures.accuracy_faces",
    "pictures.accuracy_furniture",
    "pictures.accuracy_noise",
    "pictures.accuracy_drift",
    "pictures.accuracy_poses",
    "pictures.accuracy_front_end",
    "pictures.accuracy_grey_faces",
    "pictures.accuracy_junctions",
    "pictures.accuracy_estimation",
    "pictures.accuracy_online",
    "robot.accuracy_explore",
    "robot.accuracy_map",
    "pictures.accuracy_recursion",
    "pictures.accuracy_lines",
    "pictures.accuracy_planes",
    "shapes.accuracy_scans",
    "shapes.accuracy_shapes",
    "shapes.accuracy_prototypes",
    "shapes.accuracy_newcomer",
    "shapes.accuracy_plain",
    "shapes.accuracy_three_inputs",
    "pictures.time_demo",
    "pictures.time_large",
    "pictures.time_estimation",
    "knowledge.time_facts",
    "knowledge.time_facts_in",
    "knowledge.time_answers_out",
    "knowledge.time_box_rule",
    "knowledge.time_growth",
    "knowledge.time_reasons",
    "knowledge.time_long_run",
    "knowledge.time_stopping",
    "knowledge.calibration",
    "knowledge.time_models",
    "knowledge.time_compiled",
    "shapes.time_mesh",
    "knowledge.time_batch",
    "knowledge.time_many_scenes",
    "knowledge.fuzz_models",
)
NAMES = {module.rpartition(".")[2]: module for module in MODULES}
"""Each benchmark's name, and its module in this package."""
HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
PAGE = HERE.parent / "docs" / "benchmarks.md"


def kept_reports() -> tuple[tuple[str, Mapping[str, object]], ...]:
    """The first paragraph of each benchmark's docstring and its report, of those kept."""
    kept = []
    for name, module in NAMES.items():
        path = RESULTS / f"{name}.json"
        if path.exists():
            question = (import_module(f"benchmarks.{module}").__doc__ or "").split("\n\n")[0]
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
        report = import_module(f"benchmarks.{NAMES[name]}").measure(settings).to_json()
        print(json.dumps(report) if given.json else "\n".join((*text(report), "")), flush=True)
        if given.write and not report["skipped"]:
            RESULTS.mkdir(exist_ok=True)
            kept = json.dumps(report, indent=1, ensure_ascii=False)
            (RESULTS / f"{name}.json").write_text(kept + "\n", encoding="utf-8")
    if given.write:
        PAGE.write_text(benchmarks_page(kept_reports()), encoding="utf-8")


if __name__ == "__main__":
    main()
