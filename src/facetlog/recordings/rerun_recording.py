"""A collection in Rerun: pictures where they were taken, corners as they converge, faces, verdicts.

In the world of the tour, metres. An ellipsoid is two standard deviations of a corner; outlines are
grey where a face was completed from its neighbours. Times are seconds since 1970 (timeline `time`).
"""

import socket
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.kb.explaining.verdict_text import NO_MODEL
from facetlog.perception.scene import Evidence
from facetlog.perception.types import FloatArray
from facetlog.recordings.moments import Moment
from facetlog.recordings.on_scene import face_loops, verdict_places

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene

__all__ = ["LIVE", "SUFFIX", "RerunRecording", "rerun_target"]

LIVE, SUFFIX = "live", ".rrd"
SCHEMES = ("rerun://", "rerun+http://", "rerun+https://")
SDS = 2.0
MEASURED, IMPLIED, WAY, INK = (40, 120, 210), (160, 160, 160), (210, 130, 20), (40, 40, 40)
LINE_WIDTH = 0.003  # metres
VIEWER_PORT = 9876  # of Rerun's viewer, if none is given
# Seconds to reach a viewer, and for it to take what is still to be sent at the end.
CONNECT_TIMEOUT, FLUSH_TIMEOUT = 3.0, 20.0


def rerun_target(given: str) -> str:
    """What `--rerun` gives, checked: `live`, a file .rrd or the address of a viewer; InputError."""
    if given == LIVE or given.startswith(SCHEMES) or Path(given).suffix == SUFFIX:
        return given
    raise InputError(
        f"--rerun {given!r:.60}: give live, a file whose name ends in {SUFFIX}, or the address of a"
        " viewer (rerun+http://HOST:PORT/proxy)"
    )


class RerunRecording:
    """See `Recorder`. Live it opens a viewer on this machine, or is sent to one that is open."""

    def __init__(self, target: str, name: str) -> None:
        target = rerun_target(target)
        self._way: list[tuple[float, float, float]] = []
        # What holds at each place of an area, of a tour at place 0.
        self._said: dict[int, list[str]] = {}
        self._stream = rr.RecordingStream("facetlog", recording_id=None)
        try:
            if target == LIVE:
                self._stream.spawn()
            elif target.startswith(SCHEMES):
                _check_viewer(target)
                self._stream.connect_grpc(target)
            else:
                Path(target).parent.mkdir(parents=True, exist_ok=True)
                self._stream.save(target)
        except (OSError, RuntimeError, ValueError) as exc:
            # Of a viewer that is missing it says pages: the first sentence is enough.
            why = " ".join(str(exc).split()).partition(". ")[0]
            raise InputError(f"--rerun {target}: cannot be recorded ({why})") from exc
        self._stream.send_recording_name(name)
        self._stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self._stream.log("verdict", rr.TextDocument("nothing yet"), static=False)

    def add(self, moment: Moment) -> None:
        """See `Recorder`."""
        for at, place in moment.way:
            self._stream.set_time("time", timestamp=at)
            turn = Rotation.from_euler("z", place.heading)
            self._stream.log("world/robot", _transform(np.array([place.x, place.y, 0.0]), turn))
            self._way.append((place.x, place.y, 0.0))
        self._stream.set_time("time", timestamp=moment.taken.time)
        if len(self._way) > 1:
            way = rr.LineStrips3D([self._way], colors=[WAY], radii=[LINE_WIDTH])
            self._stream.log("world/way", way)
        self._log_camera(moment)
        self._log_candidates(moment)
        if moment.scene is not None:
            self._log_scene(moment.scene, moment.place)
        if moment.recognition is not None:
            self._log_verdicts(moment)

    def close(self) -> None:
        """See `Recorder`."""
        try:
            self._stream.flush(timeout_sec=FLUSH_TIMEOUT)
        except (OSError, RuntimeError, ValueError) as exc:
            raise InputError(f"--rerun: the viewer takes no more ({exc})") from exc
        self._stream.disconnect()

    def _log_camera(self, moment: Moment) -> None:
        view, camera = moment.taken, moment.optics.camera
        turn = Rotation.from_matrix(view.pose.rotation)
        self._stream.log("world/camera", _transform(view.pose.centre, turn))
        self._stream.log(
            "world/camera/picture",
            rr.Pinhole(
                image_from_camera=camera.matrix,
                resolution=[camera.width, camera.height],
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=0.25,
            ),
        )
        picture = rr.EncodedImage(contents=moment.picture, media_type="image/png")
        self._stream.log("world/camera/picture", picture)
        self._stream.log("view", rr.TextLog(f"{view.name} {'; '.join(view.notes)}".strip()))

    def _log_candidates(self, moment: Moment) -> None:
        """Balls where views could be taken, as large as what each promised a second; that which was
        says what.
        """
        for entity, is_chosen, colour in (("candidates", False, IMPLIED), ("chosen", True, WAY)):
            found = [each for each in moment.candidates if each.is_chosen is is_chosen]
            balls = rr.Points3D(
                np.array([each.place for each in found]).reshape(-1, 3),
                radii=[each.radius for each in found],
                colors=[colour],
                labels=[each.words for each in found] if is_chosen else None,
            )
            self._stream.log(f"world/{entity}", balls)

    def _log_scene(self, scene: "Scene", place: int) -> None:
        covs = np.array([vertex.cov for vertex in scene.vertices]).reshape(-1, 3, 3)
        axes, turns, largest = _ellipsoids(covs)
        self._stream.log(
            _entity("world", place, "corners"),
            rr.Ellipsoids3D(
                centers=scene.points, half_sizes=SDS * axes, quaternions=turns, colors=[WAY]
            ),
        )
        if len(covs):
            self._stream.log(_entity("largest_sd_mm", place), rr.Scalars([1e3 * largest]))
        faces = list(face_loops(scene))
        self._stream.log(
            _entity("world", place, "faces"),
            rr.LineStrips3D(
                [np.vstack([loop, loop[:1]]) for _, loop in faces],
                colors=[
                    MEASURED if face.evidence is Evidence.MEASURED else IMPLIED for face, _ in faces
                ],
                radii=[LINE_WIDTH],
            ),
        )

    def _log_verdicts(self, moment: Moment) -> None:
        found, scene = moment.recognition, moment.scene
        if found is None or scene is None:
            return
        said = verdict_places(scene, found)
        self._stream.log(
            _entity("world", moment.place, "verdicts"),
            rr.Points3D(
                [middle for _, middle in said], labels=[text for text, _ in said], colors=[INK]
            ),
        )
        self._said[moment.place] = [text for text, _ in said] or [NO_MODEL]
        lines = [
            f"place {place}: {text}" if place else text
            for place, texts in sorted(self._said.items())
            for text in texts
        ]
        self._stream.log("verdict", rr.TextDocument("\n".join(lines)))
        for verdict in found.best:
            self._stream.log(
                _entity("sure", moment.place, verdict.model), rr.Scalars([verdict.sure])
            )


def _entity(root: str, place: int, *parts: str) -> str:
    """The path of what is known at a place of an area, 0 of a tour: other places keep theirs."""
    return "/".join((root, *((f"place{place}",) if place else ()), *parts))


def _check_viewer(address: str) -> None:
    """OSError or ValueError if nobody listens there: to send to nobody would wait for ever."""
    place = urlsplit(address)
    port = VIEWER_PORT if place.port is None else place.port
    socket.create_connection((place.hostname or "localhost", port), CONNECT_TIMEOUT).close()


def _transform(place: FloatArray, turn: Rotation) -> rr.Transform3D:
    quaternion = rr.Quaternion(xyzw=turn.as_quat(canonical=True))
    return rr.Transform3D(translation=place, rotation=quaternion)


def _ellipsoids(covs: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Half axes (n, 3) of one standard deviation, their directions as quaternions (n, 4; x, y, z,
    w), and the largest of all, 0 if there are none."""
    if not len(covs):
        return np.zeros((0, 3)), np.zeros((0, 4)), 0.0
    values, vectors = np.linalg.eigh(covs)
    # Axes of a left-handed frame are no rotation.
    vectors[:, :, 0] *= np.sign(np.linalg.det(vectors))[:, None]
    axes = np.sqrt(np.maximum(values, 0.0))
    return axes, Rotation.from_matrix(vectors).as_quat(), float(axes.max())
