"""Texts of models for properties: sentences of the grammar, laid out at random, mutated."""

from hypothesis import strategies as st

from facetlog.grammar.reading.layout import STATEMENT_WORDS

__all__ = ["model_files", "mutated_files"]

Tokens = list[str]

_NAMES = st.sampled_from(
    ["a", "b", "leg", "board", "top", "length", "tilt", "known", "least", "pair", "größe", "bar"]
)
_NUMBERS = st.sampled_from(["0", "3", "80", "0.5", "1e3", "12.25"])
_UNITS = st.sampled_from(["%", "°", "cm", "deg", "inch"])
_STRINGS = st.sampled_from(
    ['"x"', '"it lies level"', '"# no comment, (really)"', '""', '"' + "w " * 30 + '"']
)


def _joined(*parts: "str | st.SearchStrategy[Tokens]") -> st.SearchStrategy[Tokens]:
    """The tokens of words and strategies one after the other."""
    given = [st.just(p.split()) if isinstance(p, str) else p for p in parts]
    return st.tuples(*given).map(lambda found: [token for one in found for token in one])


def _maybe(part: st.SearchStrategy[Tokens]) -> st.SearchStrategy[Tokens]:
    return st.one_of(st.just([]), part)


def _listed(part: st.SearchStrategy[Tokens], most: int = 3) -> st.SearchStrategy[Tokens]:
    """One or more, commas between."""
    return st.lists(part, min_size=1, max_size=most).map(
        lambda found: [t for i, one in enumerate(found) for t in ([",", *one] if i else one)]
    )


_NAME = _NAMES.map(lambda name: [name])
_NUMBER = _NUMBERS.map(lambda number: [number])
_STRING = _STRINGS.map(lambda text: [text])
_QUANTITY = st.tuples(_NUMBERS, st.one_of(st.none(), _UNITS)).map(lambda q: [x for x in q if x])
_NAME_LIST = _listed(_NAME)
_KIND = st.sampled_from([["face"], ["edge"], ["vertex"], ["board"]])
_COUNT = st.one_of(
    _joined("at least", _NUMBER),
    _joined("exactly", _NUMBER),
    _joined("between", _NUMBER, "and", _NUMBER),
    st.just(["any", "number", "of"]),
)

_NAMED = st.one_of(
    _NAME, _joined(_NAME, ".", _NAME), _joined(_NAME, "(", _maybe(_listed(_NAME)), ")")
)
_SIGN = st.sampled_from([["+"], ["-"], ["*"], ["/"]])
_HOW = st.sampled_from([["sum"], ["lowest"], ["smallest", "gap"], ["largest", "step"]])
_MEASURE = st.recursive(
    st.one_of(_NAMED, _QUANTITY),
    lambda inner: st.one_of(
        _joined(inner, _SIGN, inner),
        _joined("-", inner),
        _joined("(", inner, ")"),
        _joined(_QUANTITY, "of", inner),
        _joined(_HOW, "of", inner),
        _joined(_NAME, "(", _listed(inner), ")"),
    ),
    max_leaves=4,
)
_FADING = _maybe(st.one_of(st.just(["sharp"]), _joined("fading", _MEASURE)))
_PLUS_MINUS = st.sampled_from([["±"], ["+/-"]])
_ATOM = st.one_of(
    _joined(_MEASURE, "=", _MEASURE, _maybe(_joined(_PLUS_MINUS, _MEASURE)), _FADING),
    _joined(_MEASURE, "at least", _MEASURE, _FADING),
    _joined(_MEASURE, "between", _MEASURE, "and", _MEASURE, _FADING),
    _joined(_MEASURE, "about", _MEASURE),
    _joined(_NAMED, "is", _maybe(st.just(["not"])), _NAME),
    _joined(_NAMED, _NAME, _NAMED),
)
_CONDITIONS = st.recursive(
    _ATOM,
    lambda inner: st.one_of(
        _joined("(", inner, ")"),
        _joined("not", "(", inner, ")"),
        _joined("(", inner, ")", "and", "(", inner, ")"),
        _joined("(", inner, ")", "or", inner),
        _joined("(", inner, ")", ",", inner),
        _joined("each", _NAME, ":", inner),
        _joined("each pair", _NAME, ",", _NAME, "of", _NAME_LIST, ":", inner),
        _joined("there are", _COUNT, "faces", _NAME, "where", inner),
    ),
    max_leaves=5,
)
_WHERE = _maybe(_joined("where", _CONDITIONS))
_EXPECT = st.one_of(
    st.just([]),
    _joined("expect :"),
    _joined("expect weakly :"),
    _joined("expect 30 % :"),
    _joined("if known :"),
)
_LINE = _joined(_maybe(_joined(_NAME, ":")), _EXPECT, _CONDITIONS, _maybe(_STRING))
_STATEMENT = st.one_of(
    _LINE,
    _LINE,
    _LINE,
    _joined("model", _NAME, _maybe(_joined("is", _NAME))),
    _STRING,
    _joined("use", _STRING),
    _joined("let", _NAME, "=", _MEASURE, _maybe(_STRING)),
    _joined("define", _NAME, "(", _NAME_LIST, ")", ":", _CONDITIONS, _maybe(_STRING)),
    _joined(_maybe(st.just(["optional"])), _KIND, _NAME_LIST, _WHERE),
    _joined(_COUNT, _maybe(st.just(["separate"])), "faces", _NAME, _WHERE),
    _joined("drop", _NAME_LIST),
    _joined("size", _NAME_LIST, ":", _listed(_MEASURE), _maybe(st.just(["longest", "first"]))),
    _joined("example", _STRING, "from", _STRING, "fails because", _NAME_LIST),
    _joined("example", _STRING, "of", _NAME, "(", _joined(_NAME, _QUANTITY), ")", "holds"),
)

_GAPS = st.sampled_from(["", "", " ", " ", "   ", "\t"])
_BREAKS = st.sampled_from(["\n", "\n    ", "  # why\n", "\n\n  # alone\n "])
_ENDS = st.sampled_from(
    ["\n", "\n  ", "\n\n", "\n\n\n\n  ", " # behind\n", "\n# alone\n", "\n\n  # in\n\n"]
)


@st.composite
def _laid_out(draw: st.DrawFn) -> str:
    """A statement's tokens with blanks, line ends and comments where they may stand."""
    tokens = draw(_STATEMENT)
    text = ""
    for i, token in enumerate(tokens):
        gap = draw(_GAPS)
        if (
            text
            and text[-1].isalnum() | (text[-1] == "_")
            and (token[0].isalnum() or token[0] == "_")
        ):
            gap = gap or " "
        may_break = i and (token in ("and", "or") or tokens[i - 1] in (",", "and", "or", "of"))
        label = i + 1 < len(tokens) and tokens[i + 1] == ":"
        if (
            may_break
            and token not in STATEMENT_WORDS
            and not label
            and draw(st.integers(0, 4)) == 0
        ):
            gap = draw(_BREAKS)
        text += gap + token
    return text


@st.composite
def model_files(draw: st.DrawFn) -> str:
    """A file of statements that can be read, most of them in models."""
    pieces = [draw(st.sampled_from(["", "# first\n", "\n\n", "model a\n"]))]
    for statement in draw(st.lists(_laid_out(), max_size=8)):
        pieces += [statement, draw(_ENDS)]
    text = "".join(pieces)
    return text.replace("\n", "\r\n") if draw(st.integers(0, 9)) == 0 else text


_BITS = st.one_of(
    st.sampled_from(list('\n\r\t\f "#(),:.±%°-+=\u00a0\u2028\ufeff')),
    st.sampled_from(["model ", "and ", "\nmodel b\n", "1e", "\r\r\n", "each ", "a:"]),
    st.text(max_size=3),
)


@st.composite
def mutated_files(draw: st.DrawFn) -> str:
    """A file with pieces taken out and put in."""
    text = draw(model_files())
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, len(text)))
        end = start + draw(st.integers(0, 4))
        text = text[:start] + draw(st.one_of(st.just(""), _BITS)) + text[end:]
    return text
