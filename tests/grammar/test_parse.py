"""Text into syntax: every form of statement and expression, and all faults at once."""

import pytest

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS
from facetlog.grammar.reading.parse import LARGEST, parse
from facetlog.grammar.source import Source
from facetlog.grammar.traversal import walk


def one(line: str) -> s.Statement:
    """The only statement of a model, without faults."""
    parsed = parse(Source("m", f"model m\n{line}"))
    assert parsed.faults == ()
    (statement,) = parsed.file.models[0].statements
    return statement


def condition(text: str) -> s.Expression:
    line = one(f"label: {text}")
    assert isinstance(line, s.Line)
    return line.condition


@pytest.mark.parametrize(
    "word",
    [
        "sum",
        "mean",
        "lowest",
        "highest",
        "smallest",
        "largest",
        "order",
        "step",
        "gap",
        "spacing",
        "hollow",
        "piece",
    ],
)
def test_words_that_are_no_statement_may_be_labels(word: str) -> None:
    line = one(f"{word}: lowest of length(leg) at least 5 cm")
    assert isinstance(line, s.Line)
    assert line.label is not None
    assert line.label.text == word


def test_a_file_is_what_stands_first_and_models_with_their_statements() -> None:
    text = 'use "a.model"\nlet x = 3 cm\nmodel b is c\n  "doc"\n  face d\nmodel e like b\n'
    file = parse(Source("m", text)).file
    assert [type(n).__name__ for n in file.statements] == ["Use", "Let"]
    first, second = file.models
    assert (first.name.text, first.ancestry, first.parent and first.parent.text) == (
        "b",
        s.Ancestry.IS,
        "c",
    )
    assert first.doc is not None
    assert first.doc.value == "doc"
    assert second.ancestry is s.Ancestry.LIKE
    assert second.statements == ()


@pytest.mark.parametrize(
    ("line", "optional", "count", "separate", "kind", "names"),
    [
        ("face a, b", False, None, False, "face", ["a", "b"]),
        ("optional edge e", True, None, False, "edge", ["e"]),
        ("one table board", False, None, False, "table", ["board"]),
        ("at least 3 faces x", False, s.CountKind.AT_LEAST, False, "faces", ["x"]),
        ("at most 2 separate elements x", False, s.CountKind.AT_MOST, True, "elements", ["x"]),
        ("exactly 1 vertex v", False, s.CountKind.EXACTLY, False, "vertex", ["v"]),
        ("between 2 and 4 chairs c", False, s.CountKind.BETWEEN, False, "chairs", ["c"]),
        ("optional any number of box p", True, s.CountKind.ANY, False, "box", ["p"]),
    ],
)
def test_parts_of_every_form(
    line: str,
    optional: bool,
    count: s.CountKind | None,
    separate: bool,
    kind: str,
    names: list[str],
) -> None:
    part = one(f'{line} where x is level "why"')
    assert isinstance(part, s.Part)
    assert part.optional is optional
    assert (part.count.kind if part.count else None) == count
    assert part.separate is separate
    assert part.kind.text == kind
    assert [n.text for n in part.names] == names
    assert isinstance(part.where, s.Property)
    assert part.reason is not None
    assert part.reason.value == "why"


@pytest.mark.parametrize(
    ("prefix", "expect", "if_known"),
    [
        ("", None, False),
        ("expect: ", "", False),
        ("expect weakly: ", "weakly", False),
        ("expect 30 %: ", "30 %", False),
        ("if known: ", None, True),
        ("expect strongly: if known: ", "strongly", True),
    ],
)
def test_prefixes_of_a_line(prefix: str, expect: str | None, if_known: bool) -> None:
    line = one(f'tall: {prefix}height(this) at least 3 cm "why"')
    assert isinstance(line, s.Line)
    assert (line.expect, line.if_known) == (expect, if_known)
    assert line.label is not None
    assert line.label.text == "tall"


@pytest.mark.parametrize(
    ("text", "comparator", "second", "fading"),
    [
        ("tilt(a) = 90 deg ± 5 deg", s.Comparator.EQUAL, True, False),
        ("tilt(a) = 90 deg +/- 5 deg fading 3 deg", s.Comparator.EQUAL, True, True),
        ("count(a) = 3", s.Comparator.EQUAL, False, False),
        ("tilt(a) at least 5° fading 1°", s.Comparator.AT_LEAST, False, True),
        ("tilt(a) at most 5°", s.Comparator.AT_MOST, False, False),
        ("tilt(a) between 5° and 6° fading 1°", s.Comparator.BETWEEN, True, True),
        ("tilt(a) about 5°", s.Comparator.ABOUT, False, False),
    ],
)
def test_comparisons_of_every_form(
    text: str, comparator: s.Comparator, second: bool, fading: bool
) -> None:
    found = condition(text)
    assert isinstance(found, s.Comparison)
    assert found.comparator is comparator
    assert (found.second is not None) is second
    assert (found.fading is not None) is fading


def test_what_follows_between_is_shared_by_both_limits() -> None:
    found = condition("height(a) between 20 % and 80 % of height(this)")
    assert isinstance(found, s.Comparison)
    assert isinstance(found.limit, s.Share)
    assert isinstance(found.second, s.Share)
    assert found.limit.whole == found.second.whole
    assert [found.limit.share.value, found.second.share.value] == [20, 80]
    apart = condition("height(a) between 20 cm and 80 % of height(this)")
    assert isinstance(apart, s.Comparison)
    assert isinstance(apart.limit, s.Quantity)


@pytest.mark.parametrize("text", ["tilt(a) at most 5° sharp", "tilt(a) = 9 deg ± 5 deg sharp"])
def test_a_limit_is_sharp_where_its_author_says_so(text: str) -> None:
    found = condition(text)
    assert isinstance(found, s.Comparison)
    assert found.sharp
    assert found.fading is None


def test_comma_binds_less_than_or_and_that_less_than_and_and_not() -> None:
    found = condition("a is x, b is x or not c is x and d is x")
    assert isinstance(found, s.And)
    assert isinstance(found.conditions[0], s.Property)
    either = found.conditions[1]
    assert isinstance(either, s.Or)
    both = either.conditions[1]
    assert isinstance(both, s.And)
    assert isinstance(both.conditions[0], s.Not)


def test_each_and_there_reach_to_the_end_of_the_line_or_bracket() -> None:
    found = condition("(each leg: leg is x, leg is y), there is no face f where f is x, f is y")
    assert isinstance(found, s.And)
    each, there = found.conditions
    assert isinstance(each, s.Each)
    assert isinstance(each.body, s.And)
    assert isinstance(there, s.There)
    assert there.some is False
    assert isinstance(there.where, s.And)


def test_what_each_and_there_go_through() -> None:
    pair = condition("each pair x, y of a, b, c: x adjoins y")
    assert isinstance(pair, s.EachOf)
    assert [n.text for n in pair.names] == ["x", "y"]
    assert [n.text for n in pair.of] == ["a", "b", "c"]
    some = condition("there are at least 2 faces f of a, b where f is x")
    assert isinstance(some, s.There)
    assert some.count is not None
    assert [n.text for n in some.of] == ["a", "b"]
    other = condition("each face f where f is x: f is y")
    assert isinstance(other, s.Each)
    assert other.kind is not None
    assert other.where is not None


def test_measures_of_every_form() -> None:
    found = condition("-2 * (length(a) + 50 % of width(b.top)) / 3 at most lowest of tilt(leg)")
    assert isinstance(found, s.Comparison)
    assert isinstance(found.measure, s.Arithmetic)
    assert found.measure.sign == "/"
    assert isinstance(found.limit, s.Aggregate)
    kinds = {type(n).__name__ for n in walk(found)}
    assert {"Negative", "Share", "Member", "Call", "Quantity"} <= kinds


def test_words_of_the_language_may_name_parts_where_they_cannot_be_meant() -> None:
    part = one("face known, number, pair, least")
    assert isinstance(part, s.Part)
    assert [n.text for n in part.names] == ["known", "number", "pair", "least"]


def test_examples_of_every_form() -> None:
    built = one('example "e" of table(width 70 cm, height 74 cm) fails because x, y')
    assert isinstance(built, s.Example)
    assert isinstance(built.scene, s.SceneBuilt)
    assert [n.text for n in built.because] == ["x", "y"]
    read = one('example "e" from "s.json" holds at least 90 %')
    assert isinstance(read, s.Example)
    assert isinstance(read.scene, s.SceneFile)
    assert read.at_least is not None
    assert read.at_least.value == 90


def test_every_node_knows_its_place() -> None:
    text = "model m\n  a: tilt(top) = 90 deg ± 5 deg, not x adjoins y   # why\n"
    line = parse(Source("m", text)).file.models[0].lines[0]
    for node in walk(line):
        written = text[node.span.start : node.span.end]
        assert written
        if isinstance(node, s.Name):
            assert written == node.text
    assert text[line.span.start : line.span.end] == "a: tilt(top) = 90 deg ± 5 deg, not x adjoins y"


@pytest.mark.parametrize(
    ("line", "code", "word", "hint"),
    [
        ("fase top", "misspelt", "fase", "`face`"),
        ("face top wher top is level", "misspelt", "wher", "`where`"),
        ("a: top at leest 3", "misspelt", "leest", "`least`"),
        ("modle b", "misspelt", "modle", "`model`"),
        ("each x of a b: x is y", "syntax", "b", "`,` or `:`"),
        ("a: top is", "syntax", "", "a name"),
        ("let q 3", "syntax", "3", "`=`"),
        ("a: top ; b", "syntax", ";", ""),
        ("a: x = 3 % %", "syntax", "%", ""),
    ],
)
def test_a_faulty_statement_is_blamed_at_the_word_that_is_wrong(
    line: str, code: str, word: str, hint: str
) -> None:
    parsed = parse(Source("m", f"model m\n{line}\nface good"))
    (fault,) = parsed.faults
    assert fault.code == code
    start, end = fault.span.start, fault.span.end
    assert fault.source.text[start:end] == word
    assert fault.source.get_line_and_column(start)[0] == 2
    assert hint in fault.hint
    assert len(parsed.file.models[0].parts) == 1


@pytest.mark.parametrize("line", ["a: tilt(x) at most 5 % oftilt(x)", "a: x is notlevel y"])
def test_words_that_are_run_together_are_no_words(line: str) -> None:
    (fault,) = parse(Source("m", f"model m\n{line}")).faults
    assert fault.code == "syntax"


def test_all_faults_of_a_file_are_reported_at_once_in_its_order() -> None:
    lines = ["model m", "fase a", "face b", "c: (x", "d: x at y", '"doc', "e: x is y"]
    parsed = parse(Source("m", "\n".join(lines)))
    found = [f.source.get_line_and_column(f.span.start)[0] for f in parsed.faults]
    assert found == [2, 4, 5, 6]
    assert len(parsed.file.models[0].statements) == 2


def test_no_more_faults_are_reported_than_a_reader_can_use() -> None:
    parsed = parse(Source("m", "model m\n" + "a b b b\n" * 500))
    assert len(parsed.faults) == MOST_FAULTS


def test_a_file_that_is_no_model_is_refused_by_its_size() -> None:
    (fault,) = parse(Source("m", "x" * (LARGEST + 1))).faults
    assert fault.code == "too-large"


@pytest.mark.parametrize(
    "line",
    [
        "a: " + "not " * 3000 + "x is y",
        "a: " + "- " * 3000 + "1 at least 3",
        "a: " + " + ".join(["1"] * 3000) + " at least 3",
        "a: " + "each x: " * 2000 + "x is y",
    ],
)
def test_what_is_nested_too_deeply_is_a_fault(line: str) -> None:
    (fault,) = parse(Source("m", f"model m\n{line}")).faults
    assert fault.code == "too-deep"
