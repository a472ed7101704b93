"""The words that a question may use, as the white list of questions has them."""

from dataclasses import dataclass

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term

__all__ = ["Word", "decode_words"]


@dataclass(frozen=True, slots=True)
class Word:
    """A word of questions.

    `kind` is what it is (fact, search, measure, relation, builtin ...), `signature` the word with
    the names of its arguments, `meaning` one line for a reader, empty if there is none.
    """

    name: str
    arity: int
    kind: str
    signature: str
    meaning: str


def decode_words(term: Term) -> tuple[Word, ...]:
    """The words that question_words/1 of words.pl says.

    Raises EngineError if the reply is something else.
    """
    if not isinstance(term, tuple):
        raise EngineError("Prolog's answer cannot be read")
    return tuple(map(_word, term))


def _word(term: Term) -> Word:
    match term:
        case Struct(
            "word",
            (Struct("/", (Atom(name), int(arity))), Atom(kind), str(signature), str(meaning)),
        ):
            return Word(name, arity, kind, signature, meaning)
    raise EngineError("Prolog's answer cannot be read")
