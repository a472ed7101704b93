"""The notebooks in examples/ run from top to bottom, and say what they are to show."""

import sys
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
MOST_SECONDS = 180


# What the kernel's packages themselves warn of.
@pytest.mark.filterwarnings("default")
@pytest.mark.slow
def test_the_notebook_runs_and_finds_the_block(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    kernels = tmp_path / "kernels" / "here"
    kernels.mkdir(parents=True)
    (kernels / "kernel.json").write_text(
        f'{{"argv": ["{sys.executable}", "-m", "ipykernel_launcher", "-f", '
        '"{connection_file}"], "display_name": "here", "language": "python"}'
    )
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path))
    notebook = nbformat.read(EXAMPLES / "recognise.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "stored without outputs"
    client = nbclient.NotebookClient(
        notebook,
        timeout=MOST_SECONDS,
        kernel_name="here",
        resources={"metadata": {"path": str(EXAMPLES)}},
    )
    client.execute()
    shown = [cell.outputs for cell in notebook.cells if cell.cell_type == "code"]
    (block,) = shown[1]
    assert "t1 is a box" in block["data"]["text/plain"]
    assert "<iframe" in block["data"]["text/html"]
    said = "".join(output["text"] for output in shown[2])
    assert "t1 is a box" in said
    assert "t1 is no chair" in said
    assert all(outputs for outputs in shown[1:])
