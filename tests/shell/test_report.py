"""The text of a report's files."""

from facetlog.report import laid_out


def test_json_has_a_line_for_each_condition() -> None:
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
