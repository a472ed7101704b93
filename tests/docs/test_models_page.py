"""Documents: each model in them is sound, each command prints what is shown, and links hold."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.grammar.reading.parse import GRAMMAR
from tests.docs.page_blocks import blocks, matches
from tests.docs.page_session import Outcome, Session

README = Path(__file__).parents[2] / "README.md"
DOCS = README.parent / "docs"
TUTORIAL, REFERENCE = DOCS / "models.md", DOCS / "model-reference.md"
SLOW = [False, pytest.param(True, marks=pytest.mark.slow)]


def list_problems(outcomes: Iterator[Outcome], page: Path) -> list[str]:
    return [f"{page.name}:{o.line}: {o.what}: {o.problem}" for o in outcomes if o.problem]


@pytest.mark.parametrize("page", [TUTORIAL, REFERENCE], ids=lambda page: page.name)
@pytest.mark.parametrize("slow", SLOW)
def test_models_and_commands_are_as_the_page_says(tmp_path, page, *, slow):
    text = page.read_text(encoding="utf-8")
    assert list_problems(Session(tmp_path, slow=slow).outcomes(text), page) == []
    assert {b.language for b in blocks(text)} >= {"model", "console"}


def test_every_word_of_the_grammar_is_in_the_reference():
    grammar = re.sub("//.*", "", GRAMMAR.read_text(encoding="utf-8"))
    words = set(re.findall('"([a-z]+)"', grammar))
    shown = set(re.findall("[a-z]+", REFERENCE.read_text(encoding="utf-8")))
    assert words - shown == set()


@pytest.mark.parametrize("slow", SLOW)
def test_what_the_readme_shows_is_printed(tmp_path, *, slow):
    page = README.read_text(encoding="utf-8")
    assert list_problems(Session(tmp_path, slow=slow).outcomes(page), README) == []
    assert {b.language for b in blocks(page)} == {"", "console", "model", "python"}


def test_the_readme_is_short():
    assert README.read_text(encoding="utf-8").count("\n") <= 120


@pytest.mark.parametrize(
    ("wanted", "got", "same"),
    [
        ("a\n…\n", "a\nb\nc\n", True),
        ("a …, c\n", "a 1.5, c\n", True),
        ("a.\n", "ab\n", False),
        ("a\n", "a\nb\n", False),
    ],
)
def test_what_a_page_leaves_out_may_be_anything(wanted, got, *, same):
    assert matches(wanted, got) is same


def anchors(page: str) -> set[str]:
    """The headings and marked places of a page as links name them."""
    titles = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    named = re.findall(r'<a id="([^"]+)">', page)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles} | {*named}


@pytest.mark.parametrize("page", [README, *sorted(DOCS.glob("*.md"))], ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    text = page.read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    for link in links:
        path, _, anchor = link.partition("#")
        to = page.parent / path if path else page
        assert to.exists(), link
        assert not anchor or anchor in anchors(to.read_text(encoding="utf-8")), link
