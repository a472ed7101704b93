"""A log of every byte on the line, as lines of JSON, that never delays the robot.

A thread of its own writes it. A full disk ends the log and is reported once; the session goes on. A
line is {"at": seconds, "direction": "in" or "out", "hex": …, "name": the packets completed by
it}; sessions begin with {"schema": 1, "start": …}. Bytes are logged as they came, packets or not.
"""

import contextlib
import json
import queue
import threading
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from facetlog.errors import InputError
from facetlog.robot.pioneer.packets.commands import name_command
from facetlog.robot.pioneer.packets.packet import Decoder, Packet
from facetlog.robot.pioneer.packets.reports import SIP_KINDS, Report

SCHEMA = 1
WAITING_LINES = 20_000
"""Lines queued for a slow disk at most: minutes of traffic."""
CLOSE_TIMEOUT = 2.0
"""Seconds for the last lines."""


def name_report(packet: Packet) -> str:
    """Return the name of a packet of the robot."""
    if packet.kind in SIP_KINDS:
        return "SIP"
    try:
        return Report(packet.kind).name
    except ValueError:
        return f"report {packet.kind}"


class TrafficLog:
    """Appends to a file; InputError if that cannot be opened."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            # Unbuffered: neither a fork nor a kill leaves half of a buffer behind.
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise InputError(f"{path}: the log cannot be written ({error.strerror})") from error
        self._waiting: queue.Queue[tuple[float, str, bytes, dict[str, object]] | None]
        self._waiting = queue.Queue(WAITING_LINES)
        self._broken: str | None = None
        self._untold: str | None = None
        self._failed: Callable[[str], None] | None = None
        self._lock = threading.Lock()
        self._names = {"in": (Decoder(), name_report), "out": (Decoder(), name_command)}
        self._thread = threading.Thread(target=self._run, name="pioneer-log", daemon=True)
        self._thread.start()

    @property
    def broken(self) -> str | None:
        """Why nothing is written any more; None while it is."""
        return self._broken

    def on_failure(self, failed: Callable[[str], None]) -> None:
        """Call back, once and from any thread, with why nothing is written any more."""
        with self._lock:
            self._failed = failed
        self._notify()

    def start(
        self, at: float, address: str, *, serial: bool, model: str | None, baud: int | None
    ) -> None:
        """Begin a session; `model` and `baud` are what the user gave."""
        wall = datetime.now(UTC).isoformat(timespec="milliseconds")
        details = {"address": address, "serial": serial, "model": model, "baud": baud}
        self._put((at, "", b"", {"schema": SCHEMA, "start": wall, **details}))

    def incoming(self, at: float, data: bytes) -> None:
        """Log bytes that came; b"" marks a discarded incomplete packet."""
        self._put((at, "in", data, {}))

    def log_outgoing(self, at: float, data: bytes, name: str | None = None) -> None:
        """Log bytes that were sent, and their name if the bytes alone do not give it."""
        self._put((at, "out", data, {} if name is None else {"name": name}))

    def note(self, at: float, **details: object) -> None:
        """Log another event."""
        self._put((at, "", b"", details))

    def close(self) -> None:
        """Write the queued lines, for a bounded time."""
        ended = False
        while not ended:
            try:
                self._waiting.put_nowait(None)
                ended = True
            except queue.Full:  # and so nothing is written any more
                with contextlib.suppress(queue.Empty):
                    self._waiting.get_nowait()
        self._thread.join(CLOSE_TIMEOUT)
        if not self._thread.is_alive():
            self._file.close()

    def _put(self, line: tuple[float, str, bytes, dict[str, object]]) -> None:
        if self._broken is not None:
            return
        try:
            self._waiting.put_nowait(line)
        except queue.Full:
            self._break("the disk does not keep up")

    def _run(self) -> None:
        while (line := self._waiting.get()) is not None:
            if self._broken is not None:
                continue
            at, direction, data, details = line
            entry: dict[str, object] = {"at": at}
            if direction:
                decoder, name_of = self._names[direction]
                found = decoder.feed(data, at) if data else decoder.expire()
                names = [name_of(each.packet) for each in found]
                entry |= {"direction": direction, "hex": data.hex(), "name": ", ".join(names)}
            entry |= details
            text = json.dumps(entry, ensure_ascii=False).encode() + b"\n"
            try:
                self._write(text)
            except OSError as error:
                self._break(error.strerror or str(error))

    def _write(self, text: bytes) -> None:
        while text:
            text = text[self._file.write(text) :]

    def _break(self, reason: str) -> None:
        with self._lock:
            if self._broken is None:
                self._broken = f"{self.path}: the log ends here, nothing more is written ({reason})"
                self._untold = self._broken
        self._notify()

    def _notify(self) -> None:
        with self._lock:
            text, failed = self._untold, self._failed
            if text is None or failed is None:
                return
            self._untold = None
        failed(text)
