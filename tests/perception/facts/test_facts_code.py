"""Facts that were kept are used only while the code that made them is the same."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from facetlog.perception.facts.facts_code import FACTS_CODE, SHAPES_CODE, facts_code_hash

ROOM = Path(__file__).parents[3] / "perception"
LOADED = """
import json, sys
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.scene_file import decode_scene
modules = [m for n, m in sys.modules.items() if n.startswith("facetlog.perception")]
print(json.dumps([m.__file__ for m in modules if m.__file__]))
"""


SHAPES = """
from facetlog.perception.reading.shape_files.clouds import cloud_files
from facetlog.perception.reading.shape_files.meshes import gltf_mesh, mesh_files
from facetlog.perception.shapes.clouds import cloud_scene
from facetlog.perception.shapes.meshes import mesh_scene
"""


@pytest.mark.parametrize(
    ("code", "patterns"), [(LOADED, FACTS_CODE), (SHAPES + LOADED, SHAPES_CODE)]
)
def test_all_that_is_loaded_to_make_facts_is_looked_at(
    code: str, patterns: tuple[str, ...]
) -> None:
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    loaded = {Path(path).resolve() for path in json.loads(said.stdout)}
    covered = {path.resolve() for pattern in patterns for path in ROOM.glob(pattern)}
    assert len(loaded) > 20
    assert loaded <= covered


def test_a_change_within_a_version_makes_another_key(tmp_path: Path) -> None:
    check = tmp_path / "surfaces" / "scene_numbers.py"
    check.parent.mkdir()
    check.write_text("LEAST = 0\n")
    before = facts_code_hash(tmp_path)
    check.write_text("LEAST = 1\n")
    facts_code_hash.cache_clear()
    changed = facts_code_hash(tmp_path)
    check.rename(check.with_name("numbers.py"))
    facts_code_hash.cache_clear()
    assert len({before, changed, facts_code_hash(tmp_path)}) == 3
