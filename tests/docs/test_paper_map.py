"""docs/paper.md: rows lead to files and tests that there are, and nothing of the paper lacks."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in (ROOT / "docs" / "paper.md").read_text().splitlines()
    if line.startswith("| ") and not line.startswith(("| of the paper", "| ---"))
]


def test_every_section_equation_figure_and_step_has_its_row():
    named = [item for row in ROWS for item in row[0].lstrip("| ").split("; ")]
    wanted = [f"Equation ({k})" for k in range(1, 15)]
    wanted += [f"Figure {k}" for k in range(1, 15)]
    wanted += [f"Step {k}" for k in range(1, 10)]
    wanted += [f"Section {s}" for s in ("1", "2", "3", "4", "4.1", "4.2", "5.1", "5.2", "5.3", "6")]
    assert len(set(named)) == len(named)
    assert set(wanted) <= set(named)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].lstrip("| "))
def test_a_row_leads_to_code_and_tests_that_there_are(row):
    _, _, here, tests = row
    code = re.findall(r"`([\w./-]+/[\w./-]*)`(?: \(`([\w.]+)`(?:, `(\w+)`)?\))?", here)
    assert code
    for path, *names in code:
        assert (ROOT / path).exists(), path
        for name in filter(None, names):
            last = name.rpartition(".")[2]
            assert re.search(rf"\b(def|class) {last}\b", (ROOT / path).read_text()), name
    found = re.findall(r"`(tests/[\w./-]+)(?:::(\w+))?`", tests)
    assert found
    for path, name in found:
        assert (ROOT / path).exists(), path
        if name:
            assert f"def {name}(" in (ROOT / path).read_text(), name
