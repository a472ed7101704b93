"""Formatting: the layout it gives, and that it changes nothing else."""

import re
from textwrap import dedent

import pytest
from hypothesis import given, settings

from facetlog.grammar.format import differences, formatted
from facetlog.grammar.reading.layout import laid_out
from facetlog.grammar.reading.parse import LARGEST, parse
from facetlog.grammar.source import Source
from tests.grammar.model_texts import model_files, mutated_files

_SPAN = re.compile(r"span=Span\(start=\d+, end=\d+\)")


def _format(text: str) -> str:
    return formatted(Source("m.model", text))


def _syntax(text: str) -> tuple[str, list[str], list[str]]:
    """Syntax, comments and faults, places apart."""
    parsed = parse(Source("m.model", text))
    tree = _SPAN.sub("", repr((parsed.file.statements, parsed.file.models)))
    faults = [f"{f.code} {f.message}" for f in parsed.faults]
    return tree, [c.text for c in parsed.file.comments], faults


def _tokens(text: str) -> list[str]:
    statements = laid_out(Source("m.model", text)).statements
    return [t.text.replace("+/-", "±") for s in statements for t in s.tokens]


def _is(before: str, after: str) -> None:
    assert _format(dedent(before)) == dedent(after)
    assert _format(dedent(after)) == dedent(after)


def test_blanks_stand_where_people_write_one() -> None:
    _is(
        """\
        let  right=90deg
        model box
        face a ,b,c
        full :share( a )at least 80%of(share(b)+-1)
        turned: angle(a,b)=- 5 ° ± 3° , a . top is level
        example "x"of cuboid ( width 10cm , depth 8cm )holds at least 90%
        """,
        """\
        let right = 90 deg

        model box
          face a, b, c
          full: share(a) at least 80 % of (share(b) + -1)
          turned: angle(a, b) = -5° ± 3°, a.top is level
          example "x" of cuboid(width 10 cm, depth 8 cm) holds at least 90 %
        """,
    )


def test_one_line_is_blank_between_models_and_at_most_one_elsewhere() -> None:
    _is(
        """\


        use "a.model"
        model a



          face x
          x is level
        model b is a


          x is upward

        """,
        """\
        use "a.model"

        model a

          face x
          x is level

        model b is a

          x is upward
        """,
    )


def test_comments_stay_at_their_statements() -> None:
    _is(
        """\
        # the file

        # about a
        model a # behind
            # about x
        face x
          x is level   # why
          # the end of a
        # about b
          # more of b
        model b
        # inside
        face y

        # after all
        """,
        """\
        # the file

        # about a
        model a  # behind
          # about x
          face x
          x is level  # why
          # the end of a

        # about b
        # more of b
        model b
          # inside
          face y

        # after all
        """,
    )


def test_a_statement_with_comments_in_it_keeps_its_lines() -> None:
    _is(
        """\
        model a
          wide: (a adjoins b   # here
           # or there
            or b adjoins c) and # both
              length(a)at least 5cm # last
        """,
        """\
        model a
          wide: (a adjoins b  # here
              # or there
              or b adjoins c) and  # both
              length(a) at least 5 cm  # last
        """,
    )


def test_reasons_of_neighbours_stand_in_a_column() -> None:
    _is(
        """\
        model a
          x is level "it lies"
          length(x) at least 5 cm "it is long"
          width(x) at least 5 cm
          up: x is upward "it looks up"

          y: x is upward and x is level "twice"
        """,
        """\
        model a
          x is level               "it lies"
          length(x) at least 5 cm  "it is long"
          width(x) at least 5 cm
          up: x is upward  "it looks up"

          y: x is upward and x is level  "twice"
        """,
    )


def test_reasons_stand_in_no_column_if_one_of_them_would_not_fit() -> None:
    long = "word " * 10
    text = (
        "model a\n"
        f'  x is level  "{long}"\n'
        '  length(x) at least 5 cm and width(x) at most 40 % of length(x)  "it is long"\n'
    )
    assert _format(text) == text


def test_a_long_statement_is_broken_at_its_loosest_joints() -> None:
    _is(
        """\
        model a
          full: each pair x, y of a, b, c: x adjoins y, dihedral(x, y) = 90 deg ± 15 deg and
            x is level or length(x) between 3 cm and 4 cm and y is level, width(x) at least
            60 % of width(y) "as in a box"
        """,
        """\
        model a
          full: each pair x, y of a, b, c: x adjoins y,
              dihedral(x, y) = 90 deg ± 15 deg and x is level
              or length(x) between 3 cm and 4 cm and y is level,
              width(x) at least 60 % of width(y)  "as in a box"
        """,
    )


def test_what_cannot_be_read_stays_exactly_as_it_stands() -> None:
    text = 'model a\n  face  x\n     x  is,level   # so\n  y: (x   is\n\n  level\n z: "open\n'
    assert _format(text) == (
        'model a\n  face x\n     x  is,level   # so\n  y: (x   is\n\n  level\n z: "open\n'
    )


def test_line_ends_stay_those_of_the_file() -> None:
    assert _format("model a\r\nface x\r\n") == "model a\r\n  face x\r\n"
    assert _format("model a\nface x\r\n") == "model a\n  face x\n"


@pytest.mark.parametrize("text", ["", "\n\n", "  \t\r\n"])
def test_nothing_becomes_nothing(text: str) -> None:
    assert _format(text) == ""


def test_a_file_too_large_to_be_parsed_comes_back_as_it_is() -> None:
    text = "face   x\n" * (LARGEST // 9 + 1)
    assert _format(text) == text


def test_differences_are_a_unified_diff() -> None:
    assert differences("a\n", "a\n", "m") == ""
    assert differences("a\nb", "a\nc\n", "m") == (
        "--- m\n+++ m (formatted)\n@@ -1,2 +1,2 @@\n a\n-b\n\\ No newline at end of file\n+c\n"
    )


@settings(max_examples=60)
@given(model_files())
def test_formatting_keeps_the_syntax_and_does_it_once(text: str) -> None:
    after = _format(text)
    assert _syntax(after) == _syntax(text)
    assert _tokens(after) == _tokens(text)
    assert _format(after) == after


@settings(max_examples=60)
@given(mutated_files())
def test_formatting_keeps_faulty_texts_and_does_it_once(text: str) -> None:
    after = _format(text)
    assert _syntax(after) == _syntax(text)
    assert _format(after) == after
