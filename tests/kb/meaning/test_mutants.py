"""The script that changes the clauses that judge: what it knows, and some of what it tries."""

import subprocess
import sys
from pathlib import Path

import pytest

from facetlog.kb.engine.engine import house

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
from equivalent_mutants import EQUIVALENT  # noqa: E402


@pytest.mark.parametrize(
    ("file", "place"), sorted({(file, place) for file, place, _ in EQUIVALENT})
)
def test_what_is_named_equivalent_stands_in_the_program(file: str, place: str) -> None:
    text = (house("kb") / "prolog" / file).read_text(encoding="utf-8")
    assert place.replace("‹", "").replace("›", "") in map(str.strip, text.splitlines())


@pytest.mark.slow
def test_of_a_few_mutants_of_each_file_none_survives() -> None:
    command = [sys.executable, str(ROOT / "scripts" / "mutants.py"), "--sample", "1"]
    command += ["--seconds", "120", "--processes", "1"]  # beside other tests
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
