"""Prolog's own unit tests, one item for each file."""

import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.parametrize("path", sorted(HERE.glob("*.plt")), ids=lambda p: p.stem)
def test_prolog_unit(path: Path) -> None:
    run = subprocess.run(
        ["swipl", "--on-warning=status", "-g", "run_tests", "-t", "halt", str(path)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
