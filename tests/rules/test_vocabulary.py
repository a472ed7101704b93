"""Every word of models has its meaning in Prolog, and every relation its sentences."""

import re

import pytest

from facetlog.grammar.compiling.writer import Bound, write_word
from facetlog.grammar.terms import Var
from facetlog.grammar.vocabulary import VOCABULARY, Word
from facetlog.kb.engine.engine import house
from facetlog.kb.explaining.wording import _RELATIONS

FILES = (house("rules") / "measures.pl", house("rules") / "vocabulary.pl")
TEXT = "".join(path.read_text(encoding="utf-8") for path in FILES)
TRUE = set(re.findall(r"^truth\((?:piece_|opening_)?(\w+)\(", TEXT, re.MULTILINE))
MEANT = set(re.findall(r"^(?:measure|truth|means)\((\w+)\(", TEXT, re.MULTILINE))


@pytest.mark.parametrize("word", VOCABULARY.values(), ids=lambda word: word.name)
def test_a_word_has_its_meaning_for_each_kind_of_element(word: Word) -> None:
    for kind in word.arguments[0]:
        arguments = (Bound(Var("X"), frozenset({kind})),) * len(word.arguments)
        assert write_word(word.name, arguments).functor in MEANT


def test_a_relation_has_its_sentences() -> None:
    assert TRUE - set(_RELATIONS) == set()
