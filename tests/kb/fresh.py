"""Python code run by a fresh interpreter that finds this facetlog."""

import os
import subprocess
import sys
from pathlib import Path

import facetlog

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(facetlog.__file__).parents[1])}


def python(code: str) -> subprocess.CompletedProcess[str]:
    """Run the code; return what it printed, and how it ended."""
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=ENVIRONMENT,
    )
