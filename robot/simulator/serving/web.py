"""The simulated robot's HTTP interface: pictures, its true state, and injection of faults.

GET / and /stream.mjpg: the camera as MJPEG. GET /frame.jpg: one picture, exposed after the request.
GET /state: the true state, as JSON. POST /faults: one fault as JSON (see faults.Fault).
"""

import json
import socket
import sys
import threading
import time
from dataclasses import asdict
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from pydantic import TypeAdapter, ValidationError

from facetlog.robot.simulator.camera.camera import Camera
from facetlog.robot.simulator.faults import Fault
from facetlog.robot.simulator.serving.endpoints import bound, split_host_and_port
from facetlog.robot.simulator.simulation import LiveSimulation

STATE_SCHEMA = 1
BOUNDARY = "picture"
PATIENCE = 0.25
"""Seconds between two looks whether a stream has ended."""
STILL_SECONDS = 5.0
"""Time-out of one picture, after which the camera counts as silent."""
SOCKET_SECONDS = 10.0
SEND_BUFFER = 1 << 17
"""Bytes of pictures buffered for a slow reader, which would get old ones otherwise."""
LARGEST_BODY = 1 << 16
FAULT = TypeAdapter(Fault)


class Web:
    """A server on a thread of its own."""

    def __init__(self, address: str, option: str, live: LiveSimulation, camera: Camera) -> None:
        host, port = split_host_and_port(address, option)
        try:
            self._server = _Server((host, port), _Handler, live, camera)
        except OSError as error:
            raise bound(error, address, option) from error
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": PATIENCE}, name="web"
        )
        self._thread.start()

    @property
    def address(self) -> str:
        """As `http://HOST:PORT`."""
        host, port = self._server.server_address[:2]
        return f"http://{host!s}:{port}"

    def close(self) -> None:
        """End the server; streams end with their camera, which is closed before."""
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = False  # they are joined when it closes

    def __init__(
        self,
        address: tuple[str, int],
        handler: type[BaseHTTPRequestHandler],
        live: LiveSimulation,
        camera: Camera,
    ) -> None:
        self.live, self.camera = live, camera
        super().__init__(address, handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Log the error of a request; a client that goes away is no error."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = SOCKET_SECONDS
    protocol_version = "HTTP/1.0"

    def do_GET(self) -> None:
        match self.path.partition("?")[0]:
            case "/" | "/stream.mjpg":
                self._stream()
            case "/frame.jpg":
                self._send_still()
            case "/state":
                with self.server.live.now() as (simulation, now):
                    state = simulation.state(now)
                self._json(HTTPStatus.OK, {"schema": STATE_SCHEMA, **asdict(state)})
            case path:
                said = f"there is no {path}: ask for /, /frame.jpg or /state"
                self._json(HTTPStatus.NOT_FOUND, {"error": said})

    def do_POST(self) -> None:
        if self.path != "/faults":
            said = f"there is no {self.path}: post to /faults"
            self._json(HTTPStatus.NOT_FOUND, {"error": said})
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > LARGEST_BODY:
            self._json(HTTPStatus.BAD_REQUEST, {"error": "give one fault as JSON"})
            return
        try:
            fault = FAULT.validate_json(self.rfile.read(int(length)))
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(str(part) for part in first["loc"])
            self._json(HTTPStatus.BAD_REQUEST, {"error": f"{place}: {first['msg']}".strip(": ")})
            return
        with self.server.live.now() as (simulation, now):
            simulation.inject(fault, now)
        self._json(HTTPStatus.OK, {"at": now, "fault": asdict(fault)})

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the base class's name
        """Log no requests."""

    def _json(self, status: HTTPStatus, content: dict[str, object]) -> None:
        self._whole(status, "application/json", json.dumps(content).encode() + b"\n")

    def _whole(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def _send_still(self) -> None:
        camera = self.server.camera
        with camera.watching():
            shot = camera.wait_for_shot(0, time.monotonic(), STILL_SECONDS)
        if shot is None:
            self._json(HTTPStatus.SERVICE_UNAVAILABLE, {"error": "the camera sends no picture"})
        else:
            self._whole(HTTPStatus.OK, "image/jpeg", shot.jpeg)

    def _stream(self) -> None:
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={BOUNDARY}")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        camera, number, began = self.server.camera, 0, time.monotonic()
        with camera.watching():
            while not camera.closed:
                shot = camera.wait_for_shot(number, began, PATIENCE)
                if shot is None:
                    continue
                number = shot.number
                head = (
                    f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n"
                    f"Content-Length: {len(shot.jpeg)}\r\nX-Simulated-Time: {shot.at:.6f}\r\n\r\n"
                )
                self.wfile.write(head.encode() + shot.jpeg + b"\r\n")
