"""What a process of ours that runs Python is started with."""

import os
import sys
from pathlib import Path

__all__ = ["importing_environment", "python_module"]


def python_module(name: str, *arguments: str) -> list[str]:
    """The command that runs a module of ours by this Python."""
    # -P: nothing is imported from the folder that the user happens to be in.
    return [sys.executable, "-P", "-m", name, *arguments]


def importing_environment() -> dict[str, str]:
    """This process's environment, with the modules that it can import."""
    paths = os.pathsep.join(str(Path(path).resolve()) for path in sys.path if path)
    return {**os.environ, "PYTHONPATH": paths}
