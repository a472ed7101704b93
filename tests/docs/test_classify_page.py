"""The examples for many machines in docs/classify.md, each on a cluster of this machine."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from facetlog.batch.output import read_rows
from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import chair, cuboid
from facetlog.perception.surfaces.scene_file import write_scene
from tests.docs.page_blocks import blocks

PAGE = Path(__file__).parents[2] / "docs" / "classify.md"
EXAMPLES = {
    block.info[1]: block.text
    for block in blocks(PAGE.read_text(encoding="utf-8"))
    if block.language == "python"
}
END = """
if not os.path.isdir("results"):
    import pyarrow.parquet
    os.mkdir("results")
    pyarrow.parquet.write_table(rows, "results/all.parquet")
"""


@pytest.mark.slow
@pytest.mark.real_engine
@pytest.mark.parametrize("name", [name for name in EXAMPLES if name != "pyarrow"])
def test_each_comes_to_the_rows_of_classify(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"needs {name}")
    monkeypatch.chdir(tmp_path)
    Path("scans").mkdir()
    for i in range(6):
        write_scene((chair(), cuboid(0.3, 0.2, 0.1))[i % 2], Path(f"scans/s{i}.json"))
    Path("scans", "bad.json").write_text("{")
    # Of a few rows many tables; as -c, for what starts Python again imports no program.
    code = f"import os\n{EXAMPLES['pyarrow']}\n{EXAMPLES[name]}\n{END}"
    code = code.replace("=100", "=2")
    paths = os.pathsep.join(path for path in sys.path if path)
    subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": paths, "PYSPARK_PYTHON": sys.executable},
        check=True,
        timeout=300,
    )
    assert main(["classify", "scans", "-o", "here.jsonl"]) == 0
    found = [row for part in Path("results").glob("*.parquet") for row in read_rows(part)]
    found = sorted(({**row, "seconds": 0} for row in found), key=lambda row: row["path"])
    assert found == [{**row, "seconds": 0} for row in read_rows(Path("here.jsonl"))]
