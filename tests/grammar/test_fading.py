"""Over which width limits fade: by default, as a model says, and where nothing fades."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.cli import main
from facetlog.grammar.analysis import analyse
from facetlog.grammar.compile import compiled
from facetlog.grammar.limits import limit_at, limits

HEAD = 'model slab\n  "A board."\n  face top\n  any number of faces side where side adjoins top\n'
TAIL = '\n  level: top is level, each side: side is upright\n  example "it" of table() fails\n'


def text(*lines: str) -> str:
    return HEAD + "".join(f"  {line}\n" for line in lines)


def fades(*lines: str) -> list[str]:
    return [one.fades for one in limits(analyse(Path("slab.model"), text(*lines)))]


def prolog(*lines: str) -> str:
    return compiled(analyse(Path("slab.model"), text(*lines))).prolog


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("share(top) at least 80 %", "fades from 72 % to 88 %"),
        ("tilt(top) at most 10 deg", "fades from 9 deg to 11 deg"),
        ("width(top) between 2 m and 4 m", "fades from 1.9 m to 2.1 m and from 3.9 m to 4.1 m"),
        ("tilt(top) = 90 deg ± 20 deg", "fades from 68 deg to 72 deg and from 108 deg to 112 deg"),
        ("offset(top, top) at most -1 m", "fades from -1.1 m to -0.9 m"),
        ("width(top) at least 50 % of length(top)", "fades over 10 % of its limit to either side"),
        ("share(top) at least 80 % sharp", "does not fade"),
        ("count(side) at least 3", "does not fade"),
        ("tilt(top) at most 10 deg fading 5 deg", "fades from 10 deg to 15 deg"),
        ("width(top) at most 1 m fading 50 %", "fades from 1 m to 1.5 m"),
        ("width(top) at most 1 m fading width(top)", "fades beyond its limit"),
        ("width(top) about 1 m", "fades from 0.8 m to 0.9 m and from 1.1 m to 1.2 m"),
    ],
)  # fmt: skip
def test_each_limit_says_from_where_to_where_it_fades(line: str, said: str) -> None:
    assert fades(line) == [said]


@given(st.integers(0, 100))
def test_a_model_says_over_which_share_its_limits_fade(share: int) -> None:
    lines = f"let fading = {share} %", "share(top) at least 50 %"
    low, high = 0.5 - share / 200, 0.5 + share / 200
    expected = f"fades from {100 * low:.4g} % to {100 * high:.4g} %" if share else "does not fade"
    assert fades(*lines) == [expected]
    written = f"soft(at_least(share(Top), 0.5), {share / 100:g})" if share else "at_least(share"
    assert written in prolog(*lines)


def test_limits_fade_by_a_tenth_in_what_is_compiled_and_those_that_only_choose_do_not() -> None:
    found = prolog("share(top) at least 50 %")
    assert "soft(at_least(share(Top), 0.5), 0.1)" in found
    assert "possible(at_least(share(Top), 0.5))" in found


@pytest.mark.parametrize(
    "line", ["share(top) at least 50 % sharp", "count(side) * 2 at least 6", "tilt(top) at least 0"]
)
def test_what_is_sharp_counts_or_is_compared_with_nought_does_not_fade(line: str) -> None:
    assert "soft(" not in prolog(line)


def test_a_model_that_is_like_another_fades_as_it_says_itself() -> None:
    child = 'model thin like slab\n  "It."\n  let fading = 30 %\n'
    written = text("share(top) at least 50 %") + TAIL + child
    found = compiled(analyse(Path("slab.model"), written)).prolog
    assert "soft(at_least(share(Top), 0.5), 0.1)" in found
    assert "soft(at_least(share(Top), 0.5), 0.3)" in found


@pytest.mark.parametrize("value", ["5 cm", "0.1", "110 %", "-5 %"])
def test_a_fading_that_is_no_share_is_a_fault(value: str) -> None:
    faults = analyse(
        Path("slab.model"), text(f"let fading = {value}", "tilt(top) at most 9 deg")
    ).faults
    assert [f.message for f in faults if f.code == "fading"] == [
        "a model's fading is a share of its limits, from 0 % to 100 %"
    ]


def test_a_fading_of_the_models_own_is_no_unused_constant() -> None:
    found = analyse(Path("slab.model"), text("let fading = 20 %", "tilt(top) at most 9 deg") + TAIL)
    assert not {f.code for f in found.faults} & {"unused-constant", "taken"}


def test_the_innermost_limit_is_found_where_one_looks() -> None:
    written = text("tilt(top) at most 9 deg and share(top) at least 50 %")
    found = analyse(Path("slab.model"), written)
    one = limit_at(found, written.index("50 %"))
    assert one is not None
    assert one.text == "share(top) at least 50 %"
    assert limit_at(found, 3) is None


def test_check_lists_the_limits_with_their_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("slab.model").write_text(text("share(top) at least 80 %"), encoding="utf-8")
    main(["model", "check", "--limits", "slab.model"])
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == "slab.model:5:3: share(top) at least 80 %: fades from 72 % to 88 %"
    assert main(["model", "check", "--limits", "--output", "json", "slab.model"]) == 2
    assert "leave out --output json" in capsys.readouterr().err
