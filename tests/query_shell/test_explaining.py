"""Explanations: what a scene's file says never steers the terminal."""

from facetlog.query_shell.explaining import Explanation


def test_lines_hold_no_control_characters_and_keep_their_indentation() -> None:
    said = Explanation(True, ("t1 is a box", "  seen in a\x1b]0;t\x07.png\r"), {})
    assert said.lines == ("t1 is a box", "  seen in a ]0;t .png ")
