"""A collection as an MCAP file of ROS 2 messages, for Foxglove, RViz and `ros2 bag`.

Metres, radians, seconds; axes as REP 103 has them, frames as REP 105: `map` is the world of the
tour, `odom` where the robot stood when the driver connected, `base_link` the robot (x ahead, y
left), `camera_optical_frame` the camera (x right, y down, z along the view). Message times are the
moments at which a state was reported.

| topic | type | when |
| --- | --- | --- |
| /tf | tf2_msgs/TFMessage | map → odom → base_link with every report, → camera with every view |
| /odom | nav_msgs/Odometry | with every report while the robot drives |
| /joint_states | sensor_msgs/JointState | head_pan (left is positive), head_tilt (up is positive) |
| /camera/camera_info | sensor_msgs/CameraInfo | with every view |
| /camera/image/compressed | sensor_msgs/CompressedImage | PNG |
| /camera/pose | geometry_msgs/PoseWithCovarianceStamped | the camera in map |
| /facetlog/faces, /facetlog/verdicts | visualization_msgs/MarkerArray | with every view |
| /facetlog/candidates | visualization_msgs/MarkerArray | with a view that was chosen of several |
"""

import math
import shutil
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError, make_missing_extra_error
from facetlog.perception.scene import Evidence
from facetlog.perception.types import FloatArray
from facetlog.recordings.frames import Moment
from facetlog.recordings.on_scene import find_verdict_places, iter_face_loops
from facetlog.robot.camera.optics import Optics
from facetlog.robot.pioneer.state import OdometryCovariance
from facetlog.robot.pose2 import Pose2

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.perception.scene import Scene

try:
    from rosbags.interfaces import Nodetype
    from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
    from rosbags.typesys import Stores, get_typestore
except ModuleNotFoundError as exc:
    raise make_missing_extra_error("an MCAP recording", "rosbags", "mcap") from exc

__all__ = ["SUFFIX", "McapRecording", "checked_mcap"]

SUFFIX = ".mcap"
ODOM, BASE, CAMERA = "odom", "base_link", "camera_optical_frame"
TOPICS = {
    "/tf": "tf2_msgs/msg/TFMessage",
    "/odom": "nav_msgs/msg/Odometry",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "/camera/image/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "/facetlog/faces": "visualization_msgs/msg/MarkerArray",
    "/facetlog/verdicts": "visualization_msgs/msg/MarkerArray",
    "/facetlog/candidates": "visualization_msgs/msg/MarkerArray",
}
JOINTS = ["head_pan", "head_tilt"]
# Coefficients in the order of each distortion model of ROS.
LENSES = {
    "PINHOLE": ("plumb_bob", ("k1", "k2", "p1", "p2", "k3")),
    "OPENCV": ("plumb_bob", ("k1", "k2", "p1", "p2", "k3")),
    "OPENCV_FISHEYE": ("equidistant", ("k1", "k2", "k3", "k4")),
}
LINE_WIDTH, TEXT_HEIGHT = 0.004, 0.06  # metres
MEASURED, IMPLIED, INK = (0.1, 0.45, 0.8, 1.0), (0.6, 0.6, 0.6, 1.0), (0.1, 0.1, 0.1, 1.0)
CHOSEN = (0.85, 0.5, 0.1, 1.0)
ON_FLOOR = (0, 1, 5)

MAP = "map"
"""The frame of markers."""
NANO = 1_000_000_000
# Of visualization_msgs/Marker.
SPHERE, LINE_STRIP, TEXT_VIEW_FACING, ADD, DELETE_ALL = 2, 4, 9, 0, 3
ZEROS: dict[str, Any] = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}


def checked_mcap(path: Path) -> Path:
    """Return the path of `--mcap`. Raise InputError for another kind of file."""
    if path.suffix != SUFFIX or path.is_dir():
        raise InputError(f"--mcap {path}: give a file whose name ends in {SUFFIX}")
    return path


class McapRecording:
    """See `Recorder`. The file is there, whole, once it is closed; an older one is replaced.

    Without a view there is none, and an older one stays.
    """

    def __init__(self, path: Path) -> None:
        self._path = checked_mcap(path)
        # rosbags writes a folder with a description beside the file, which alone is a recording.
        self._folder = path.with_name(f".{path.name}.part")
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._ros = RosMessages(self._store)
        self._last: tuple[float, Pose2] | None = None
        self._run: float | None = None
        self._sure = OdometryCovariance()
        self._views = 0
        # The last scene and verdicts: a viewer shows the last markers of a topic.
        self._scene: Scene | None = None
        self._recognition: Recognition | None = None
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(self._folder, ignore_errors=True)
            self._writer = Writer(self._folder, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        except (OSError, WriterError) as exc:
            raise InputError(f"{path}: cannot be written ({exc})") from exc
        self._topics = {
            topic: self._writer.add_connection(topic, kind, typestore=self._store)
            for topic, kind in TOPICS.items()
        }

    def add(self, moment: Moment) -> None:
        """See `Recorder`."""
        try:
            self._add_way(moment)
            self._add_view(moment)
            self._views += 1
        except OSError as exc:
            raise InputError(f"{self._path}: cannot be written ({exc})") from exc

    def close(self) -> None:
        """See `Recorder`."""
        try:
            self._writer.close()
            written = self._folder / f"{self._folder.name}{SUFFIX}"
            if self._views:
                written.replace(self._path)
        except OSError as exc:
            raise InputError(f"{self._path}: cannot be written ({exc})") from exc
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _add_way(self, moment: Moment) -> None:
        run = moment.run
        if self._run != run.began:
            # Odometry begins anew with each run; the way of the one before ended somewhere else.
            self._run, self._last = run.began, None
            self._sure = OdometryCovariance()
        before = moment.way[:1] if self._last is None else (self._last,)
        for (before_at, before_place), (at, place) in pairwise((*before, *moment.way)):
            there, here = run.origin.between(before_place), run.origin.between(place)
            self._write("/tf", at, transforms=self._robot_frames(at, run.origin, here))
            self._sure.move(there, here)
            seconds, step = at - before_at, there.between(here)
            speed = (step.x / seconds, step.heading / seconds) if seconds > 0 else (0.0, 0.0)
            self._write(
                "/odom",
                at,
                header=self._ros.header(at, ODOM),
                child_frame_id=BASE,
                pose=self._ros.make(
                    "geometry_msgs/msg/PoseWithCovariance",
                    pose=self._ros.pose(*_of_robot(here)),
                    covariance=_on_floor(self._sure.covariance),
                ),
                twist=self._ros.make(
                    "geometry_msgs/msg/TwistWithCovariance",
                    twist=self._ros.make(
                        "geometry_msgs/msg/Twist",
                        linear=self._ros.vector(speed[0], 0.0, 0.0),
                        angular=self._ros.vector(0.0, 0.0, speed[1]),
                    ),
                ),
            )

        self._last = moment.way[-1] if moment.way else self._last

    def _add_view(self, moment: Moment) -> None:
        view, at = moment.taken, moment.taken.time
        centre, turn = view.pose.centre, Rotation.from_matrix(view.pose.rotation)
        map_from_robot = Rotation.from_euler("z", view.robot.heading)
        off = map_from_robot.inv().apply(centre - np.array([view.robot.x, view.robot.y, 0.0]))
        start = view.robot.compose(view.odometry.inverse())
        frames = self._robot_frames(at, start, view.odometry)
        frames.append(self._ros.transform(at, BASE, CAMERA, off, map_from_robot.inv() * turn))
        self._write("/tf", at, transforms=frames)
        self._write(
            "/joint_states",
            at,
            header=self._ros.header(at, BASE),
            name=JOINTS,
            position=np.array([view.pan, view.tilt]),
        )
        self._write("/camera/camera_info", at, **self._camera_info(at, moment.optics))
        self._write(
            "/camera/image/compressed",
            at,
            header=self._ros.header(at, CAMERA),
            format="png",
            data=np.frombuffer(moment.picture, dtype=np.uint8),
        )
        self._write(
            "/camera/pose",
            at,
            header=self._ros.header(at, MAP),
            pose=self._ros.make(
                "geometry_msgs/msg/PoseWithCovariance",
                pose=self._ros.pose(centre, turn),
                covariance=np.ascontiguousarray(view.covariance, dtype=np.float64).ravel(),
            ),
        )
        if moment.scene is not None:
            self._scene, self._recognition = moment.scene, moment.recognition
        self._write("/facetlog/faces", at, markers=self._faces(at))
        if moment.candidates:
            self._write("/facetlog/candidates", at, markers=self._candidates(moment))
        if self._recognition is not None:
            self._write("/facetlog/verdicts", at, markers=self._verdicts(at))

    def _faces(self, at: float) -> list[Any]:
        markers = [self._ros.clear_markers(at)]
        if self._scene is None:
            return markers
        for number, (face, loop) in enumerate(iter_face_loops(self._scene)):
            outline = (*loop, loop[0])
            points = [self._ros.point(p) for p in outline]
            colour = MEASURED if face.evidence is Evidence.MEASURED else IMPLIED
            markers.append(
                self._ros.marker(at, "faces", number, LINE_STRIP, colour, LINE_WIDTH, points=points)
            )
        return markers

    def _verdicts(self, at: float) -> list[Any]:
        markers = [self._ros.clear_markers(at)]
        if self._scene is None or self._recognition is None:
            return markers
        kind, size = TEXT_VIEW_FACING, TEXT_HEIGHT
        for number, (said, middle) in enumerate(
            find_verdict_places(self._scene, self._recognition)
        ):
            markers.append(
                self._ros.marker(at, "verdicts", number, kind, INK, size, text=said, place=middle)
            )
        return markers

    def _candidates(self, moment: Moment) -> list[Any]:
        """Return a ball where each view would be taken, the larger the more it promised a
        second.
        """
        at, markers = moment.taken.time, [self._ros.clear_markers(moment.taken.time)]
        for number, each in enumerate(moment.candidates):
            colour, size = CHOSEN if each.is_chosen else IMPLIED, 2 * each.radius
            markers.append(
                self._ros.marker(at, "candidates", number, SPHERE, colour, size, place=each.place)
            )
            if each.is_chosen:
                above = each.place + np.array([0.0, 0.0, 2 * TEXT_HEIGHT])
                words, kind = each.words, TEXT_VIEW_FACING
                markers.append(
                    self._ros.marker(
                        at, "why", number, kind, INK, TEXT_HEIGHT, text=words, place=above
                    )
                )
        return markers

    def _camera_info(self, at: float, optics: Optics) -> dict[str, Any]:
        camera = optics.camera
        model, names = LENSES[optics.model]
        k = camera.matrix
        return {
            "header": self._ros.header(at, CAMERA),
            "height": camera.height,
            "width": camera.width,
            "distortion_model": model,
            "d": np.array([optics.coefficient(name) for name in names]),
            "k": k.ravel(),
            "r": np.eye(3).ravel(),
            "p": np.column_stack([k, np.zeros(3)]).ravel(),
        }

    def _robot_frames(self, at: float, start: Pose2, here: Pose2) -> list[Any]:
        return [
            self._ros.transform(at, MAP, ODOM, *_of_robot(start)),
            self._ros.transform(at, ODOM, BASE, *_of_robot(here)),
        ]

    def _write(self, topic: str, at: float, **fields: Any) -> None:
        kind = TOPICS[topic]
        data = self._store.serialize_cdr(self._ros.make(kind, **fields), kind)
        self._writer.write(self._topics[topic], nanoseconds(at), data)


def _of_robot(pose: Pose2) -> tuple[FloatArray, Rotation]:
    heading = Rotation.from_euler("z", math.remainder(pose.heading, 2 * math.pi))
    return np.array([pose.x, pose.y, 0.0]), heading


def _on_floor(covariance: FloatArray) -> FloatArray:
    """Return a covariance of x, y, heading (3, 3) as ROS has it: (36,) of x, y, z and turns about
    them, where what the floor holds fast has none.
    """
    whole = np.zeros((6, 6))
    whole[np.ix_(ON_FLOOR, ON_FLOOR)] = covariance
    return whole.ravel()


class RosMessages:
    """Makes messages of the types of a `store`; times are seconds, places metres."""

    def __init__(self, store: "Typestore") -> None:
        self._store = store

    def make(self, kind: str, **fields: Any) -> Any:
        """Return a message of a type, as "geometry_msgs/msg/Pose"; fields not given are zero."""
        _, wanted = self._store.fielddefs[kind]
        absent = {name: self._zero(*of) for name, of in wanted if name not in fields}
        return self._store.types[kind](**fields, **absent)

    def _zero(self, node: Nodetype, of: Any) -> Any:
        """Return zero, an empty text, an empty list or a message of zeros for a field."""
        if node is Nodetype.NAME:
            return self.make(of)
        if node is Nodetype.BASE:
            return ZEROS.get(of[0], 0)
        (inner, kind), count = of
        if inner is Nodetype.BASE and kind[0] != "string":
            return np.zeros(count if node is Nodetype.ARRAY else 0, dtype=kind[0])
        return []

    def point(self, place: FloatArray) -> Any:
        """Return geometry_msgs/Point."""
        x, y, z = map(float, place)
        return self.make("geometry_msgs/msg/Point", x=x, y=y, z=z)

    def pose(self, place: FloatArray, turn: Rotation) -> Any:
        """Return geometry_msgs/Pose."""
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self.point(place),
            orientation=self.quaternion(turn),
        )

    def quaternion(self, turn: Rotation) -> Any:
        """Return geometry_msgs/Quaternion."""
        x, y, z, w = turn.as_quat(canonical=True).tolist()
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def vector(self, x: float, y: float, z: float) -> Any:
        """Return geometry_msgs/Vector3."""
        return self.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))

    def header(self, at: float, frame: str) -> Any:
        """Return std_msgs/Header of a time and a frame."""
        seconds, rest = divmod(nanoseconds(at), NANO)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def transform(
        self, at: float, parent: str, child: str, place: FloatArray, turn: Rotation
    ) -> Any:
        """Return geometry_msgs/TransformStamped from a parent's frame to a child's."""
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(at, parent),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self.vector(*place),
                rotation=self.quaternion(turn),
            ),
        )

    def marker(
        self,
        at: float,
        group: str,
        number: int,
        kind: int,
        colour: tuple[float, float, float, float],
        size: float,
        *,
        points: "list[Any] | None" = None,
        text: str = "",
        place: FloatArray | None = None,
    ) -> Any:
        """Return visualization_msgs/Marker in the map, of a namespace and a number there."""
        r, g, b, a = colour
        return self.make(
            "visualization_msgs/msg/Marker",
            header=self.header(at, MAP),
            ns=group,
            id=number,
            type=kind,
            action=ADD,
            pose=self.pose(np.zeros(3) if place is None else place, Rotation.identity()),
            scale=self.vector(size, size, size),
            color=self.make("std_msgs/msg/ColorRGBA", r=r, g=g, b=b, a=a),
            points=points or [],
            text=text,
        )

    def clear_markers(self, at: float) -> Any:
        """Return the marker that removes those of the view before."""
        header = self.header(at, MAP)
        return self.make("visualization_msgs/msg/Marker", header=header, action=DELETE_ALL)


def nanoseconds(at: float) -> int:
    """Return a time as ROS has it."""
    seconds = math.floor(at)
    return seconds * NANO + round((at - seconds) * NANO)
