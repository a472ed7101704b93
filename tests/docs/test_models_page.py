"""docs/models.md: every model in it is sound, and every command prints what it says."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.grammar.library import builtin_names
from tests.docs.page_blocks import Block, blocks, commands, matches
from tests.docs.page_session import Outcome, Session

PAGE = Path(__file__).parents[2] / "docs" / "models.md"
TEXT = PAGE.read_text(encoding="utf-8")
README = Path(__file__).parents[2] / "README.md"


def told(outcomes: Iterator[Outcome], page: Path = PAGE) -> list[str]:
    return [f"{page.name}:{o.line}: {o.what}: {o.problem}" for o in outcomes if o.problem]


def test_models_and_commands_of_the_page_are_as_it_says(tmp_path: Path) -> None:
    assert told(Session(tmp_path, slow=False).outcomes(TEXT)) == []


@pytest.mark.slow
def test_what_takes_long_is_as_the_page_says(tmp_path: Path) -> None:
    assert told(Session(tmp_path, slow=True).outcomes(TEXT)) == []


@pytest.mark.parametrize("slow", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_what_the_readme_shows_is_printed(tmp_path: Path, *, slow: bool) -> None:
    page = README.read_text(encoding="utf-8")
    assert told(Session(tmp_path, slow=slow).outcomes(page), README) == []
    assert {b.language for b in blocks(page)} == {"", "console", "model", "python"}


def test_the_readme_is_short() -> None:
    assert README.read_text(encoding="utf-8").count("\n") <= 150


def test_the_page_has_blocks_of_each_kind() -> None:
    kinds = {block.language for block in blocks(TEXT)}
    assert kinds >= {"model", "prolog", "python", "console"}
    run = [c for b in blocks(TEXT) if b.language == "console" for c in commands(b)]
    done = {tuple(c.words.split()[1:3]) for c in run}
    assert done >= {("model", name) for name in ("new", "check", "format", "test", "compile")}


def outcomes(page: str, folder: Path) -> list[Outcome]:
    return list(Session(folder, slow=False).outcomes(page))


def test_a_faulty_model_is_found(tmp_path: Path) -> None:
    page = "```model a.model\nmodel a\n  face top\n  level: top is leval\n```\n"
    (found,) = outcomes(page, tmp_path)
    assert found.line == 2
    assert "leval" in found.problem


def test_lines_are_checked_with_the_parts_that_they_speak_of(tmp_path: Path) -> None:
    lines = "```model\ntop adjoins side\n```\n"
    assert "side" in outcomes(f"<!-- with: face top -->\n{lines}", tmp_path)[0].problem
    assert not outcomes(f"<!-- with: face top; face side -->\n\n{lines}", tmp_path)[0].problem


def test_faults_that_a_page_shows_are_compared_and_mistaken_lines_withdrawn(tmp_path: Path) -> None:
    page = (
        "```model a.model\nmodel a\n  face top\n  level: top is level\n```\n"
        "```model a.model + mistaken\n  high: top is hihg\n```\n"
        "```console\n$ facetlog model check a.model\na.model:4:16: error: …hihg…\n…\n```\n"
        "```console\n$ facetlog model check a.model\nno such output\n```\n"
    )
    *right, last = outcomes(page, tmp_path)
    assert all(not o.problem for o in right)
    assert "1 file, no faults" in last.problem


def test_other_programs_and_unknown_blocks_are_told(tmp_path: Path) -> None:
    page = "```console\n$ rm -r x\n```\n```ruby\n```\n"
    first, second = outcomes(page, tmp_path)
    assert "rm is not run" in first.problem
    assert "no test reads" in second.problem


def test_a_console_block_begins_with_a_command() -> None:
    with pytest.raises(ValueError, match="line 3"):
        list(commands(Block(3, ("console",), "text\n$ facetlog\n", "")))


@pytest.mark.parametrize(
    ("wanted", "got", "same"),
    [
        ("a\n", "a\n", True),
        ("a\n", "b\n", False),
        ("a\n…\n", "a\nb\nc\n", True),
        ("…\nc\n", "a\nb\nc\n", True),
        ("a …, c\n", "a 1.5, c\n", True),
        ("a.\n", "ab\n", False),
        ("a\n", "a\nb\n", False),
    ],
)
def test_what_a_page_leaves_out_may_be_anything(wanted: str, got: str, *, same: bool) -> None:
    assert matches(wanted, got) is same


def anchors(page: str) -> set[str]:
    """The headings of a page as links name them."""
    titles = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [PAGE, PAGE.with_name("README.md"), README], ids=lambda p: str(p))
def test_every_link_leads_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    assert links
    for link in links:
        path, _, anchor = link.partition("#")
        to = page.parent / path if path else page
        assert to.exists(), link
        assert not anchor or anchor in anchors(to.read_text(encoding="utf-8")), link


def test_every_built_in_model_is_described() -> None:
    _, _, told_of = TEXT.partition("## The models that come with facetlog\n")
    described = re.findall(r"^\*\*.+\*\* \(\[(\w+)\.model\]", told_of, re.MULTILINE)
    assert sorted(described) == sorted(builtin_names())
