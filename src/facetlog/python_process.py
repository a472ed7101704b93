"""Command and environment of child processes that run Python."""

import os
import sys
from pathlib import Path

__all__ = ["get_import_path", "make_importing_environment", "make_module_command"]


def make_module_command(name: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of ours with this Python."""
    # -P: nothing is imported from the folder that the user happens to be in.
    return [sys.executable, "-P", "-m", name, *arguments]


def get_import_path() -> str:
    """Return where this process imports modules from, as PYTHONPATH has it."""
    return os.pathsep.join(str(Path(path).resolve()) for path in sys.path if path)


def make_importing_environment() -> dict[str, str]:
    """Return this process's environment, with the modules that it can import."""
    return {**os.environ, "PYTHONPATH": get_import_path()}
