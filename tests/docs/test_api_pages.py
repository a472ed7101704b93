"""docs/api: every public name is in the reference with its docstring, and examples come out so."""

import ast
import doctest
import importlib.util
import inspect
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

import facetlog
from tests.docs.page_blocks import blocks

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "api"
REFERENCE = (PAGES / "reference.md").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^::: (\S+)$", REFERENCE, re.MULTILINE)


def _explained(place: object) -> dict[str, bool]:
    """The values that a module or class names, and whether a string stands below each."""
    found = ast.parse(inspect.getsource(place)).body  # type: ignore[arg-type]
    body = found[0].body if isinstance(found[0], ast.ClassDef) else found
    return {
        ast.unparse(value.targets[0] if isinstance(value, ast.Assign) else value.target): (
            isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        )
        for value, after in pairwise([*body, ast.Pass()])
        if isinstance(value, ast.Assign | ast.AnnAssign)
    }


def test_the_reference_has_every_public_name_once():
    own = [name.removeprefix("facetlog.") for name in ENTRIES if name.count(".") == 1]
    assert sorted(own) == sorted(facetlog.__all__)


def test_what_the_reference_has_besides_says_what_it_is():
    others = [name.rpartition(".") for name in ENTRIES if name.count(".") > 1]
    assert others
    for place, _, name in others:
        module = importlib.import_module(place)
        public = getattr(module, name)
        assert public.__doc__ if inspect.isclass(public) else _explained(module)[name], name


@pytest.mark.parametrize("name", facetlog.__all__)
def test_every_public_name_has_a_docstring(name):
    public = getattr(facetlog, name)
    if isinstance(public, str):
        assert _explained(facetlog)[name]
        return
    assert (public.__doc__ or "").strip()
    if not inspect.isclass(public):
        return
    assert not public.__doc__.startswith(f"{name}(")  # as dataclasses have it without one
    fields = _explained(public)
    members = {member for member in vars(public) if not member.startswith("_")} | fields.keys()
    said = {m for m in members if fields.get(m) or (m not in fields and getattr(public, m).__doc__)}
    assert {m for m in members - said if not m.startswith("_")} == set()


def test_examples_come_out_as_the_page_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    page = PAGES / "index.md"
    found = list(blocks(page.read_text(encoding="utf-8")))
    assert {block.language for block in found} == {"pycon"}
    names: dict[str, object] = {}
    for block in found:
        example = doctest.DocTestParser().get_doctest(
            block.text.replace("…", "..."), names, page.name, str(page), block.line
        )
        said: list[str] = []
        runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
        runner.run(example, out=said.append, clear_globs=False)
        assert said == []
        names = example.globs


def test_pages_name_neither_addresses_nor_places_of_a_machine():
    for path in (ROOT / "mkdocs.yml", *PAGES.iterdir()):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"https?://|(?<![\w.])/(home|root|work|tmp|opt|usr)/", text), path


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("mkdocs") is None, reason="needs facetlog[docs]")
def test_the_pages_are_built_without_warnings(tmp_path):
    argv = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(tmp_path)]
    built = subprocess.run(argv, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    page = (tmp_path / "reference.html").read_text(encoding="utf-8")
    for name in ENTRIES:
        assert f'id="{name}"' in page
    assert str(ROOT) not in page
    assert not re.search(r"""(src|href)="(https?:)?//""", page)
