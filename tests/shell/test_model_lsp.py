"""`facetlog model lsp`: the server that editors start, with the builders that examples may use."""

import pytest

from facetlog.commands.model.check import checked
from facetlog.commands.model.scenes import list_builder_sizes
from facetlog.grammar import language_server
from facetlog.grammar.language_server.project import Project, diagnostics


def test_the_server_is_given_the_builders_of_examples(run, monkeypatch):
    given = []
    monkeypatch.setattr(language_server, "run", given.append)
    assert run("model", "lsp")[0] == 0
    assert given == [list_builder_sizes()]
    assert "width" in given[0]["cuboid"]


@pytest.mark.parametrize(
    "text",
    [
        "# only a comment\n",
        'model slab\n  "A slab."\n  face top where top is level\n\n'
        "  tilted: tilt(top) at most 2,5 deg  “or so”\n"
        '  example "a" of cubod(width 30 cm) holds\n'
        '  example "b" of cuboid(breadth 30 cm, width 4) fails\n',
    ],
)
def test_an_editor_is_shown_what_model_check_reports(text, tmp_path):
    path = tmp_path / "slab.model"
    path.write_text(text)
    _, faults = checked(path)
    project = Project(builders=list_builder_sizes())
    project.open(path.as_uri(), text)
    shown = [(one.code, one.range.start.line + 1) for one in diagnostics(project, path)]
    assert faults
    assert shown == [(f.code, f.source.get_line_and_column(f.span.start)[0]) for f in faults]
