"""docs/pictures/vocabulary.svg: as the script draws it now, of words that there are."""

import re
import runpy
from pathlib import Path
from xml.etree import ElementTree

import pytest

from facetlog.grammar.vocabulary import VOCABULARY

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "draw_vocabulary.py"
PICTURE = ROOT / "docs" / "pictures" / "vocabulary.svg"


def test_the_picture_is_as_the_measures_are_now() -> None:
    assert runpy.run_path(str(SCRIPT))["main"](["--check"]) == 0


def test_another_picture_is_found_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = runpy.run_path(str(SCRIPT))
    old = tmp_path / "vocabulary.svg"
    old.write_text(PICTURE.read_text(encoding="utf-8").replace("%<", "<", 1), encoding="utf-8")
    script["main"].__globals__["PICTURE"] = old
    assert script["main"](["--check"]) == 1
    assert script["main"]([]) == 0
    assert old.read_text(encoding="utf-8") == PICTURE.read_text(encoding="utf-8")
    assert capsys.readouterr().out == "vocabulary.svg\n" * 2


def test_the_picture_shows_words_of_the_language() -> None:
    text = PICTURE.read_text(encoding="utf-8")
    ElementTree.fromstring(text)  # noqa: S314
    words = re.findall(r'class="word"[^>]*>(\w+)<', text)
    assert len(words) == len(set(words)) == 13
    for word in words:
        assert word in VOCABULARY
