"""Messages of ROS 2 as recordings have them: poses, transforms, markers, with their headers."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rosbags.interfaces import Nodetype
from scipy.spatial.transform import Rotation

from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

__all__ = ["LINE_STRIP", "MAP", "SPHERE", "TEXT_VIEW_FACING", "RosMessages", "nanoseconds"]

MAP = "map"
"""The frame of markers."""
NANO = 1_000_000_000
# Of visualization_msgs/Marker.
SPHERE, LINE_STRIP, TEXT_VIEW_FACING, ADD, DELETE_ALL = 2, 4, 9, 0, 3
ZEROS: dict[str, Any] = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}


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
        """geometry_msgs/Point."""
        x, y, z = map(float, place)
        return self.make("geometry_msgs/msg/Point", x=x, y=y, z=z)

    def pose(self, place: FloatArray, turn: Rotation) -> Any:
        """geometry_msgs/Pose."""
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self.point(place),
            orientation=self.quaternion(turn),
        )

    def quaternion(self, turn: Rotation) -> Any:
        """geometry_msgs/Quaternion."""
        x, y, z, w = turn.as_quat(canonical=True).tolist()
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def vector(self, x: float, y: float, z: float) -> Any:
        """geometry_msgs/Vector3."""
        return self.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))

    def header(self, at: float, frame: str) -> Any:
        """std_msgs/Header of a time and a frame."""
        seconds, rest = divmod(nanoseconds(at), NANO)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def transform(
        self, at: float, parent: str, child: str, place: FloatArray, turn: Rotation
    ) -> Any:
        """geometry_msgs/TransformStamped from a parent's frame to a child's."""
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
        """visualization_msgs/Marker in the map, of a namespace and a number there."""
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
    """A time as ROS has it."""
    seconds = math.floor(at)
    return seconds * NANO + round((at - seconds) * NANO)
