"""The command line, run in a folder of its own."""

import pytest

from facetlog.cli import main


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Return a function that runs a command in `tmp_path`: its exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def call(*argv):
        capsys.readouterr()
        code = main([str(word) for word in argv])
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def refused(run):
    """Return a function that runs a command that must end with 2; its one line on stderr."""

    def call(*argv):
        code, out, err = run(*argv)
        assert (code, out) == (2, "")
        assert err.startswith("facetlog: ")
        assert err.count("\n") == 1
        return err

    return call
