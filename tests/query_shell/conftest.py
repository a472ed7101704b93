"""A scene and a model on disk, and a shell with the scene loaded."""

import pytest

from facetlog.query_shell.screen import Screen
from facetlog.query_shell.session import Session
from facetlog.query_shell.shell import Shell

from .scenes import write_block

MODEL = """\
model lid
  "A face that faces up."

  face lid

  up: lid is upward  "it faces up"
"""


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    for name in ("XDG_CACHE_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(name, str(tmp_path / name))


@pytest.fixture
def scene(tmp_path):
    return write_block(tmp_path / "block")


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "lid.model"
    path.write_text(MODEL)
    return path


@pytest.fixture
def shell(scene):
    with Session() as session:
        session.load_scenes([scene])
        yield Shell(session, Screen(), limit=None)


@pytest.fixture
def said(capsys):
    """Return a function that takes what was written to stdout and stderr since its last call."""

    def taken() -> tuple[str, str]:
        out, err = capsys.readouterr()
        return out, err

    return taken
