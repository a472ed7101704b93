"""Facts that were kept are used only while the code that made them is the same."""

import json
import subprocess
import sys
from pathlib import Path

from facetlog.perception.facts.facts_code import FACTS_CODE, facts_code_hash

ROOM = Path(__file__).parents[3] / "perception"
LOADED = """
import json, sys
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.scene_file import decode_scene
modules = [m for n, m in sys.modules.items() if n.startswith("facetlog.perception")]
print(json.dumps([m.__file__ for m in modules if m.__file__]))
"""


def test_all_that_is_loaded_to_make_facts_is_looked_at() -> None:
    said = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, check=True)
    loaded = {Path(path).resolve() for path in json.loads(said.stdout)}
    covered = {path.resolve() for pattern in FACTS_CODE for path in ROOM.glob(pattern)}
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
