"""All benchmarks, or some of them: `python -m benchmarks [NAME …] [--seeds N] [--first-seed N]
[--json] [--write] [--page]`.

With --write each report is kept as benchmarks/results/NAME.json, and both pages are made of all
reports that are kept there: docs/benchmarks.md, the headline figures, and out/benchmarks.md, all
tables. With --page they are made without measuring anything.
"""

import json
import re
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from benchmarks.common import Settings, make_settings_parser, text
from benchmarks.page import Reports, make_headline_page, make_tables_page

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
PAGE = HERE.parent / "docs" / "benchmarks.md"
TABLES = HERE.parent / "out" / "benchmarks.md"
IS_BENCHMARK = re.compile(r"(accuracy|time)_\w+|calibration")


def find_benchmarks() -> Mapping[str, str]:
    """Return each benchmark's name and its module in this package, by folder and name."""
    paths = sorted(path for path in HERE.glob("*/*.py") if IS_BENCHMARK.fullmatch(path.stem))
    return {path.stem: f"benchmarks.{path.parent.name}.{path.stem}" for path in paths}


NAMES = find_benchmarks()


def read_kept_reports() -> Reports:
    """Return the reports that are kept, by benchmark."""
    paths = [RESULTS / f"{name}.json" for name in NAMES]
    return {p.stem: json.loads(p.read_text(encoding="utf-8")) for p in paths if p.exists()}


def write_pages() -> None:
    """Write docs/benchmarks.md and out/benchmarks.md from the reports that are kept."""
    reports = read_kept_reports()
    docs = {name: import_module(NAMES[name]).__doc__ or "" for name in reports}
    questions = {name: " ".join(doc.split("\n\n")[0].split()) for name, doc in docs.items()}
    PAGE.write_text(make_headline_page(reports), encoding="utf-8")
    TABLES.parent.mkdir(exist_ok=True)
    TABLES.write_text(make_tables_page(reports, questions), encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmarks that are named, one after the other."""
    parser = make_settings_parser("python -m benchmarks", __doc__ or "")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--write", action="store_true", help="keep the reports, make the pages")
    parser.add_argument("--page", action="store_true", help="make the pages, measure nothing")
    given = parser.parse_args(arguments)
    unknown = set(given.names) - set(NAMES)
    if unknown:
        parser.error(f"there is no benchmark {', '.join(sorted(unknown))}")
    settings = Settings(given.seeds, given.first_seed)
    for name in () if given.page else given.names or NAMES:
        print(f"{name} …", file=sys.stderr)
        report = import_module(NAMES[name]).measure(settings).to_json()
        print(json.dumps(report) if given.json else "\n".join((*text(report), "")), flush=True)
        if given.write and not report["skipped"]:
            RESULTS.mkdir(exist_ok=True)
            kept = json.dumps(report, indent=1, ensure_ascii=False)
            (RESULTS / f"{name}.json").write_text(kept + "\n", encoding="utf-8")
    if given.write or given.page:
        write_pages()


if __name__ == "__main__":
    main()
