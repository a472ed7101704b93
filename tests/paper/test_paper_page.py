"""`demo --paper`: one page with the paper's figures from a run, beside what it prints."""

import re
from decimal import ROUND_DOWN, Decimal
from html.parser import HTMLParser

import pytest

from facetlog.cli import main
from facetlog.paper.page import PAGE_FILE, plane_iterations, point_iterations, printed

# Three.js, inside the viewer, names these; nothing is fetched from them.
NAMED = {"http://www.w3.org/1999/xhtml", "https://github.com/mrdoob/three.js/pull/23228"}


class Tags(HTMLParser):
    """The tags of a page with their attributes."""

    def __init__(self, text):
        super().__init__()
        self.tags = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    out = tmp_path_factory.mktemp("paper") / "out"
    assert main(["demo", "--paper", "-o", str(out)]) == 0
    assert {p.name for p in out.iterdir()} == {PAGE_FILE, "run.json"}
    return (out / PAGE_FILE).read_text()


@pytest.mark.slow
def test_the_page_has_figures_8_to_14_and_the_verdict(text):
    ids = [attributes.get("id") for _, attributes in Tags(text).tags]
    assert [f"figure-{k}" for k in range(8, 15)] == [
        i for i in ids if i and i.startswith("figure-")
    ]
    assert '<p class="yes">t1 is a box (' in text
    assert "two of its sides were seen, at a right angle" in text


def test_nothing_is_fetched_from_anywhere(text):
    for tag, attributes in Tags(text).tags:
        assert tag not in ("link", "object", "embed")
        source = attributes.get("src") or attributes.get("href") or ""
        assert source.startswith(("data:", "#")) or not source
    found = set(re.findall(r"https?://[^\s\"'<>&,)]+", text))
    assert found <= NAMED
    assert len(text) < 8e6


def test_every_printed_figure_stands_beside_the_computed_one_that_it_rounds_or_is_cut_from(text):
    for iteration in (*point_iterations(), *plane_iterations()):
        for _, told, computed in iteration.rows:
            unit = Decimal(1).scaleb(Decimal(told).as_tuple().exponent)
            rounded = Decimal(computed).quantize(unit)
            cut = Decimal(computed).quantize(unit, ROUND_DOWN)
            assert Decimal(told) in (rounded, cut)
            assert f'<td class="n">{told}</td><td class="n">{computed}</td>' in text
    count = sum(len(i.rows) for i in point_iterations())
    assert count == 9 * len(printed()["point"]["iteration"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--paper"], "give a folder for it by -o"),
        (["--paper", "-o", "x", "--world", "table"], "reruns the paper's experiment"),
        (["--paper", "-o", "x", "--json"], "reruns the paper's experiment"),
    ],
)
def test_what_does_not_go_with_it_is_one_line(options, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["demo", *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
