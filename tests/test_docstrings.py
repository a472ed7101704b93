"""Docstrings of the product are sentences that are understood at the first reading."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("perception", "grammar", "kb", "robot", "src/facetlog")
# Beginnings of answers to a question that only the writer knows.
RIDDLE = re.compile(r"(?:Those|The same|What|Nothing;|Of)\b")
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def test_no_docstring_begins_as_a_riddle() -> None:
    paths = {path.resolve() for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    found = [
        f"{path.relative_to(ROOT)}: {getattr(node, 'name', 'module')}: {text.splitlines()[0]}"
        for path in sorted(paths)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, DOCUMENTED) and RIDDLE.match(text := ast.get_docstring(node) or "")
    ]
    assert not found, "begin with a verb, or with the noun that it is:\n" + "\n".join(found)
