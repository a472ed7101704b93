"""docs/commands.md has a row for every command."""

from pathlib import Path

import typer

from facetlog.cli import make_app

PAGE = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")


def test_the_page_lists_all_commands():
    cells = [line.split(" | ")[0] for line in PAGE.splitlines() if line.startswith("| `facetlog ")]
    for name, command in typer.main.get_command(make_app()).commands.items():
        own = [cell.replace("`", " ").split() for cell in cells]
        words = {word.strip(",") for cell in own if cell[2] == name for word in cell}
        assert {name, *getattr(command, "commands", ())} - words == set()
