"""Every word of models has its meaning in Prolog, for each kind of element that it may be about."""

import re

import pytest

from facetlog.grammar.compiling.writer import Bound, write_word
from facetlog.grammar.terms import Var
from facetlog.grammar.vocabulary import VOCABULARY, Word
from facetlog.kb.engine.engine import house

FILES = (house("rules") / "measures.pl", house("rules") / "vocabulary.pl")
TEXT = "".join(path.read_text(encoding="utf-8") for path in FILES)
MEANT = set(re.findall(r"^(?:measure|truth|means)\((\w+)\(", TEXT, re.MULTILINE))


@pytest.mark.parametrize("word", VOCABULARY.values(), ids=lambda word: word.name)
def test_a_word_has_its_meaning(word: Word) -> None:
    for kind in word.arguments[0]:
        arguments = (Bound(Var("X"), frozenset({kind})),) * len(word.arguments)
        assert write_word(word.name, arguments).functor in MEANT
