"""An editor for tests: it speaks JSON-RPC with a language server in a process of its own."""

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

__all__ = ["Editor", "RequestRefused", "errors"]

PATIENCE_S = 20.0
"""Seconds after which an answer will not come any more, on a machine that is busy."""

SOURCES = Path(__file__).parents[2] / "src"

SERVER = (sys.executable, "-m", "facetlog.grammar.language_server")


class RequestRefused(Exception):  # noqa: N818 - what the server says, not what went wrong here
    """The server answered a request with an error, of which this is the code."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def errors(faults: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The faults that keep a model from being used: severity 1 of the protocol."""
    return [fault for fault in faults if fault["severity"] == 1]


class Editor:
    """A process with a server, and the texts that are open in it."""

    def __init__(
        self,
        folder: Path,
        command: tuple[str, ...] = SERVER,
        *,
        initialize: bool = True,
        **general: object,
    ) -> None:
        environment = {**os.environ, "PYTHONPATH": str(SOURCES)}
        self.folder = folder
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            cwd=folder,
        )
        self._answers: dict[int | None, dict[str, Any]] = {}
        self._messages: queue.Queue[dict[str, Any] | None] = queue.Queue()
        self._sent: dict[str, list[dict[str, Any]]] = {}
        self._last_id = 0
        self._versions: dict[str, int] = {}
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.capabilities: dict[str, Any] = {}
        if initialize:
            self.initialize(**general)

    def initialize(self, **general: object) -> None:
        """Begins the conversation."""
        self.capabilities = self.ask(
            "initialize",
            {
                "processId": None,
                "rootUri": self.folder.as_uri(),
                "workspaceFolders": [{"uri": self.folder.as_uri(), "name": "w"}],
                "capabilities": {"general": general},
            },
        )["capabilities"]
        self.tell("initialized", {})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self.ask("shutdown", None)
                self.tell("exit", None)
                assert self.process.wait(PATIENCE_S) == 0
        finally:
            self.process.kill()
            self.leave()

    def leave(self) -> None:
        """Closes what the server reads from, as a killed editor does, and awaits its end."""
        assert self.process.stdin
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        for stream in (self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()

    # ---------------------------------------------------------- messages

    def _read(self) -> None:
        assert self.process.stdout
        while header := self.process.stdout.readline():
            length = 0
            while header.strip():
                name, _, value = header.partition(b":")
                if name.lower() == b"content-length":
                    length = int(value)
                header = self.process.stdout.readline()
            self._messages.put(json.loads(self.process.stdout.read(length)))
        self._messages.put(None)

    def _send(self, message: Mapping[str, object]) -> None:
        self.send_raw(json.dumps({"jsonrpc": "2.0", **message}).encode())

    def send_raw(self, body: bytes) -> None:
        """Sends a body as it is."""
        assert self.process.stdin
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%b" % (len(body), body))
        self.process.stdin.flush()

    def _take(self) -> None:
        message = self._messages.get(timeout=PATIENCE_S)
        assert message is not None, "the server has ended"
        if message.get("method") == "textDocument/publishDiagnostics":
            sent = message["params"]
            self._sent.setdefault(sent["uri"], []).append(sent["diagnostics"])
        elif "id" in message and "method" not in message:
            self._answers[message["id"]] = message
        elif message.get("method") == "window/showMessage":
            raise AssertionError(message["params"]["message"])

    def tell(self, method: str, params: object) -> None:
        """Sends a notification."""
        self._send({"method": method, "params": params})

    def ask(self, method: str, params: object) -> Any:
        """The answer to a request; RequestRefused if it is an error."""
        return self.ask_as({"method": method, "params": params})

    def ask_as(self, message: Mapping[str, object]) -> Any:
        """The answer to a message that gets the next number, whatever else is in it."""
        self._last_id += 1
        number = self._last_id
        self._send({"id": number, **message})
        return self.answer(number)

    def answer(self, number: int | None) -> Any:
        """The answer to the request of a number; null is that of what was no request."""
        while number not in self._answers:
            self._take()
        answer = self._answers.pop(number)
        if "error" in answer:
            raise RequestRefused(answer["error"]["message"], answer["error"]["code"])
        return answer["result"]

    # ------------------------------------------------------------- texts

    def uri(self, name: str) -> str:
        """The address of a file of the folder."""
        return (self.folder / name).as_uri()

    def open(self, name: str, text: str) -> list[dict[str, Any]]:
        """Opens a text, which need not be on disk; returns its faults."""
        self._versions[name] = 1
        item = {"uri": self.uri(name), "languageId": "facetlog-model", "version": 1, "text": text}
        self._sent.pop(self.uri(name), None)
        self.tell("textDocument/didOpen", {"textDocument": item})
        return self.faults(name)

    def change(self, name: str, *changes: Mapping[str, object]) -> None:
        """Changes a text; a change has a `range` and a `text`, or a text alone."""
        self._versions[name] += 1
        document = {"uri": self.uri(name), "version": self._versions[name]}
        self._sent.pop(self.uri(name), None)
        self.tell(
            "textDocument/didChange", {"textDocument": document, "contentChanges": list(changes)}
        )

    def close(self, name: str) -> None:
        """Closes a text."""
        self.tell("textDocument/didClose", {"textDocument": {"uri": self.uri(name)}})

    def faults(self, name: str, severity: int = 1) -> list[dict[str, Any]]:
        """The errors of a text (2: its warnings) that are sent next."""
        while not self._sent.get(self.uri(name)):
            self._take()
        return [one for one in self._sent[self.uri(name)].pop() if one["severity"] == severity]

    def at(self, method: str, name: str, line: int, column: int, **more: object) -> Any:
        """Asks about a place: line and column from 0."""
        document, position = {"uri": self.uri(name)}, {"line": line, "character": column}
        return self.ask(
            f"textDocument/{method}", {"textDocument": document, "position": position, **more}
        )

    def completions(self, name: str, line: int, column: int) -> dict[str, dict[str, Any]]:
        """What may be written at a place, by label."""
        return {item["label"]: item for item in self.at("completion", name, line, column)["items"]}
