"""`facetlog-scene/1` as pydantic reads it, and its JSON Schema.

Most parts are those of perception/scene.py; those that are written otherwise have a model here.
"""

import base64
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PositiveInt, WithJsonSchema

from facetlog.perception.scene import Body, Edge, Face, Patch, Vertex
from facetlog.perception.types import Index, Share

__all__ = ["FORMAT", "PosedCameraRecord", "SceneRecord", "SeenLatticeRecord", "SightLinesRecord"]

FORMAT = "facetlog-scene/1"

Vector3 = tuple[float, float, float]


def _decode_base64(text: bytes) -> bytes:
    """Return the bytes; ValueError for anything beside base64, which pydantic's own passes over."""
    try:
        return base64.b64decode(text, validate=True)
    except ValueError as exc:
        raise ValueError("is no base64") from exc


Base64 = Annotated[
    bytes,
    AfterValidator(_decode_base64),
    WithJsonSchema({"format": "base64", "type": "string"}),
]


class _Record(BaseModel):
    # It holds for the parts of a scene within, too.
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class SightLinesRecord(_Record):
    """Lines of sight from a place, of a view (index) or none, to points of surfaces.

    `ends` are their coordinates x, y, z one after the other, little-endian float32, in base64.
    """

    origin: Vector3
    ends: Base64
    view: Index | None = None


class SeenLatticeRecord(_Record):
    """Lines of sight from views (indices), each from its origin, to points of a plane on a lattice.

    Point (i, j) is at corner + i steps[0] + j steps[1], for i and j below the rows and columns in
    `size`. `shown` has a bit for each view, row and column, eight a byte, the first one highest,
    compressed by zlib, in base64. `wrong` is the share of points known to be hidden that pass as
    shown. The plane is that of the `ground`, or else of a face.
    """

    corner: Vector3
    steps: tuple[Vector3, Vector3]
    size: tuple[PositiveInt, PositiveInt]
    views: tuple[Index, ...]
    origins: tuple[Vector3, ...]
    shown: Base64
    wrong: Share | None = None
    ground: bool = True


class PosedCameraRecord(_Record):
    """The camera of a view, a pinhole without distortion, and where it stood.

    `size` is width and height, `focal` fx and fy, `middle` cx and cy, px; `rotation` is
    world_from_camera (x right, y down, z forward), `centre` in the world.
    """

    size: tuple[PositiveInt, PositiveInt]
    focal: tuple[float, float]
    middle: tuple[float, float]
    rotation: tuple[Vector3, Vector3, Vector3]
    centre: Vector3


class SceneRecord(_Record):
    """A reconstructed scene: vertices, edges and flat faces with their uncertainty."""

    model_config = ConfigDict(title=FORMAT)

    format: Literal["facetlog-scene/1"] = Field(alias="schema")
    name: str
    metric: bool = Field(
        default=False, description="lengths are metres; else their unit is unknown"
    )
    up: Vector3 | None = Field(default=None, description="unit vector upwards, if known")
    views: tuple[str, ...] = ()
    vertices: tuple[Vertex, ...] = ()
    edges: tuple[Edge, ...] = ()
    faces: tuple[Face, ...] = ()
    warnings: tuple[str, ...] = ()
    patches: tuple[Patch, ...] = ()
    bodies: tuple[Body, ...] = ()
    sights: tuple[SightLinesRecord, ...] = ()
    cameras: tuple[PosedCameraRecord, ...] = Field(
        default=(), description="one for each view, or none"
    )
    lattices: tuple[SeenLatticeRecord, ...] = ()
    scale_sd: float = Field(
        default=0.0,
        ge=0.0,
        lt=1.0,
        description="relative standard deviation of metres, which is in no covariance",
    )
