"""Prolog's own unit tests, one item for each file."""

import subprocess
from pathlib import Path

import pytest

from facetlog.kb.engine.engine import house
from facetlog.kb.loading.builtin_rules import builtin_rules
from facetlog.kb.loading.encode import declarations

HERE = Path(__file__).parent
BRIDGE = house("kb") / "prolog" / "bridge.pl"


@pytest.mark.parametrize("path", sorted(HERE.parent.rglob("*.plt")), ids=lambda p: p.stem)
def test_prolog_unit(path: Path, tmp_path: Path) -> None:
    driver = tmp_path / "driver.pl"
    driver.write_text(
        f":- load_files({str(BRIDGE)!r}, [silent(true)]).\n"
        f":- asserta(user:file_search_path(facetlog, {str(builtin_rules())!r})).\n"
        f":- schema:declare_facts({declarations()}).\n"
        f":- load_files({str(path)!r}, [silent(true)]).\n",
        encoding="utf-8",
    )
    run = subprocess.run(
        ["swipl", "--on-warning=status", "-g", "run_tests", "-t", "halt", driver],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    said = run.stdout + run.stderr
    assert run.returncode == 0, said
    assert "No tests to run" not in said
