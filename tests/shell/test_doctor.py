"""`facetlog doctor`: what is there, what is missing, and the way to it."""

import importlib.metadata
import json

import pytest

from facetlog.cli import main
from facetlog.errors import EngineError

REQUIRED = [
    "numpy>=2.0",
    "prompt_toolkit>=3.0.43",
    'laspy[lazrs]>=2.5; extra == "las"',
    'pandas>=2.2; extra == "tables"',
    'pytest>=8.2; extra == "dev"',
    'mkdocs-material>=9.5; extra == "docs"',
]


def _findings(capsys: pytest.CaptureFixture[str]) -> dict[str, dict[str, str]]:
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "facetlog-doctor/1"
    return {each["name"]: each for each in printed["findings"]}


@pytest.fixture(autouse=True)
def _requires(monkeypatch):
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: REQUIRED)


def test_where_all_is_there_it_says_so_line_by_line(capsys):
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    rows = [line.split()[:2] for line in out.splitlines()]
    assert ["SWI-Prolog", "ok"] in rows
    assert ["numpy", "ok"] in rows
    assert "built-in models load" in out
    assert "pytest" not in out
    assert "[docs]" not in out


def test_a_missing_package_is_named_with_the_way_to_it(capsys, monkeypatch):
    there = importlib.metadata.version

    def version(name: str) -> str:
        if name in ("prompt_toolkit", "laspy"):
            raise importlib.metadata.PackageNotFoundError(name)
        return there(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    assert main(["doctor", "--json"]) == 3
    found = _findings(capsys)
    assert found["prompt_toolkit"]["standing"] == "MISSING"
    assert found["prompt_toolkit"]["detail"] == "pip install prompt_toolkit"
    assert found["[las]"]["standing"] == "not there"
    assert found["[las]"]["detail"] == "pip install 'facetlog[las]'"
    assert found["[tables]"]["standing"] == "ok"


def test_an_engine_that_does_not_start_is_missing_with_the_way_out(capsys, monkeypatch):
    def fails() -> None:
        raise EngineError("SWI-Prolog is missing or cannot be used: install swi-prolog")

    monkeypatch.setattr("facetlog.kb.recognize.open_knowledge_base", fails)
    assert main(["doctor", "--json"]) == 3
    assert _findings(capsys)["SWI-Prolog"]["detail"].endswith("install swi-prolog")
