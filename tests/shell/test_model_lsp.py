"""`facetlog model lsp`: the server that editors start, with the builders that examples may use."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import pytest

from facetlog.commands.model.check import checked
from facetlog.commands.model.scenes import builder_sizes
from facetlog.grammar.language_server.diagnostics import diagnostics
from facetlog.grammar.language_server.project import Project


@pytest.fixture
def server(tmp_path: Path) -> Iterator["subprocess.Popen[bytes]"]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(
        [sys.executable, "-m", "facetlog", "model", "lsp"],
        cwd=tmp_path,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        yield process
        process.kill()


def _send(stream: "IO[bytes] | None", **message: object) -> None:
    assert stream is not None
    body = json.dumps({"jsonrpc": "2.0", **message}).encode()
    stream.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
    stream.flush()


def _reply(stream: "IO[bytes] | None", number: int) -> Any:
    """The result of the request of that number; notes that come before it are passed over."""
    assert stream is not None
    while True:
        length = 0
        while (line := stream.readline().strip()) or not length:
            assert line, "the server has ended"
            name, _, value = line.partition(b":")
            if name.lower() == b"content-length":
                length = int(value)
        message = json.loads(stream.read(length))
        if message.get("id") == number:
            return message["result"]


@pytest.mark.slow
def test_an_editor_is_offered_the_builders_of_examples(
    server: "subprocess.Popen[bytes]", tmp_path: Path
) -> None:
    text = 'model slab\n  face top\n  level: top is level\n  example "a" of cub'
    place = (tmp_path / "slab.model").as_uri()
    document = {"uri": place, "languageId": "facetlog-model", "version": 1, "text": text}
    settings = {"processId": None, "rootUri": None, "capabilities": {}}
    _send(server.stdin, id=1, method="initialize", params=settings)
    assert "completionProvider" in _reply(server.stdout, 1)["capabilities"]
    _send(server.stdin, method="initialized", params={})
    _send(server.stdin, method="textDocument/didOpen", params={"textDocument": document})
    position = {"line": 3, "character": len(text.splitlines()[3])}
    asked = {"textDocument": {"uri": place}, "position": position}
    _send(server.stdin, id=2, method="textDocument/completion", params=asked)
    found = _reply(server.stdout, 2)
    items = found if isinstance(found, list) else found["items"]
    assert "cuboid" in {item["label"] for item in items}
    _send(server.stdin, id=3, method="shutdown")
    assert _reply(server.stdout, 3) is None
    _send(server.stdin, method="exit")
    assert server.wait(timeout=20) == 0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "# only a comment\n",
        'model slab\n  "A slab."\n  face top where top is level\n\n'
        "  tilted: tilt(top) at most 2,5 deg  “or so”\n"
        '  example "a" of cubod(width 30 cm) holds\n'
        '  example "b" of cuboid(breadth 30 cm, width 4) fails\n',
    ],
)
def test_an_editor_is_shown_what_model_check_reports(text: str, tmp_path: Path) -> None:
    path = tmp_path / "slab.model"
    path.write_text(text)
    _, faults = checked(path)
    project = Project(builders=builder_sizes())
    project.open(path.as_uri(), text)
    shown = [(one.code, one.range.start.line + 1) for one in diagnostics(project, path)]
    assert faults
    assert shown == [(f.code, f.source.line_and_column(f.span.start)[0]) for f in faults]


def test_a_model_that_two_open_files_define_is_shown_in_both(tmp_path: Path) -> None:
    project = Project()
    for name in ("a", "b"):
        text = "model slab\n  face top\n  ok: top is level\n"
        project.open((tmp_path / f"{name}.model").as_uri(), text)
    for path in project.open_models:
        codes = [one.code for one in diagnostics(project, path)]
        assert codes.count("same-name") == 1
    project.close((tmp_path / "b.model").as_uri())
    assert "same-name" not in [one.code for one in diagnostics(project, tmp_path / "a.model")]
