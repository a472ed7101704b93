"""The text of a report's files."""

import json
import re
from typing import Any

import pytest

from facetlog.cli import main
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.report import laid_out

MOST_BYTES = 64_000


def test_json_has_a_line_for_each_condition():
    data = {"verdicts": [{"model": "box", "conditions": [{"a": 1, "b": [1, 2]}, {}]}], "empty": []}
    assert laid_out(data, 4).splitlines() == [
        "{",
        '"verdicts": [',
        "{",
        '"model": "box",',
        '"conditions": [',
        '{"a": 1, "b": [1, 2]},',
        "{}",
        "]",
        "}",
        "],",
        '"empty": []',
        "}",
    ]


@pytest.mark.slow
def test_what_is_said_of_a_block_is_short_and_in_full_the_whole_proof(monkeypatch, capsys):
    views = ViewSet("block", ())
    monkeypatch.setattr(
        "facetlog.commands.recognize.render_simulated_views", lambda *_, **__: views
    )
    monkeypatch.setattr("facetlog.pipeline.reconstruct_views", lambda *_, **__: cuboid())

    def said(*options: str) -> str:
        assert main(["demo", *options]) == 0
        return capsys.readouterr().out

    lines = said("--raw").splitlines()
    assert max(map(len, lines)) <= 100
    box = lines[lines.index("t1 is a box (degree 100%)") :]
    end = next(k for k, line in enumerate(box) if k and not line.startswith(" "))
    assert end <= 20
    assert any("square: they meet at right angles – angle(" in line for line in box[:end])
    assert box[end - 1].startswith("  + third: three of its sides were seen – ")
    written = said("--json")
    assert len(written) <= MOST_BYTES
    assert any(line.startswith('{"label": "square", ') for line in written.splitlines())

    assert re.search(r"\[box.model:\d+: each pair x, y of a, b, c: angle\(x, y\)", said("--full"))
    full = json.loads(said("--json", "--full"))
    for condition in (c for v in full["verdicts"] for c in v["conditions"]):
        assert condition.pop("proof")["state"] == condition["state"]
        condition.pop("text")
    brief = json.loads(written)
    assert contains_all_of(full, brief)
    for whole, short in zip(full["verdicts"], brief["verdicts"], strict=True):
        fails = short["state"] == "fails"
        assert short["sizes"].keys() == (set() if fails else whole["sizes"].keys())
        for one, other in zip(whole["conditions"], short["conditions"], strict=True):
            if not fails or other["state"] != "holds":
                assert one.keys() == other.keys()
                assert (one["because"] or {}).keys() == (other["because"] or {}).keys()


def contains_all_of(full: Any, brief: Any) -> bool:
    """Whether all that is in the brief data is in the full, to six digits."""
    if isinstance(brief, dict):
        return all(contains_all_of(full[key], value) for key, value in brief.items())
    if isinstance(brief, list):
        return not brief or all(contains_all_of(*pair) for pair in zip(full, brief, strict=True))
    return bool(full == (pytest.approx(brief, rel=1e-5) if isinstance(brief, float) else brief))
