"""The compiled Prolog files: the same program as from their text, whatever happened to the file."""

import subprocess
import sys
from pathlib import Path

from facetlog.python_process import make_importing_environment

CODE = """
from facetlog.kb.knowledge_base import KnowledgeBase

with KnowledgeBase() as base:
    print(sorted(base.models), base.send("cache_identity", ""))
"""


def _run(cache: Path, switch: str = "") -> bytes:
    environment = make_importing_environment()
    environment |= {"XDG_CACHE_HOME": str(cache), "FACETLOG_CACHE": switch}
    return subprocess.run(
        [sys.executable, "-c", CODE], env=environment, check=True, capture_output=True
    ).stdout


def test_a_program_is_kept_compiled_and_a_damaged_file_is_made_again(tmp_path: Path) -> None:
    expected = _run(tmp_path, "off")
    assert expected
    assert not list(tmp_path.rglob("*.scene"))
    assert _run(tmp_path) == expected
    (path,) = tmp_path.rglob("*.scene")
    kept = path.read_bytes()
    assert _run(tmp_path) == expected
    assert path.read_bytes() == kept
    for damaged in (kept[: len(kept) // 2], kept[:-9] + b"x" + kept[-8:], b""):
        path.write_bytes(damaged)
        assert _run(tmp_path) == expected
        assert len(path.read_bytes()) == len(kept)
