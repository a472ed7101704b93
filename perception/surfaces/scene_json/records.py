"""Scenes as JSON say what they hold in these models: `facetlog-scene/1` and its JSON Schema."""

import base64
from typing import Annotated, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    EncodedBytes,
    EncoderProtocol,
    Field,
    FiniteFloat,
    NonNegativeInt,
    PositiveInt,
)
from pydantic_core import PydanticCustomError

from facetlog.perception.scene import Evidence
from facetlog.perception.types import PositionLabel

__all__ = [
    "FORMAT",
    "FaceRecord",
    "FaceSightRecord",
    "ObservationRecord",
    "PatchRecord",
    "PosedCameraRecord",
    "SceneRecord",
    "SeenLatticeRecord",
    "SightLinesRecord",
    "VertexRecord",
]

FORMAT = "facetlog-scene/1"

Vector2 = tuple[FiniteFloat, FiniteFloat]
Vector3 = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Vector4 = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Ring = Annotated[tuple[NonNegativeInt, ...], Field(min_length=3)]


class _Base64(EncoderProtocol):
    """Base64 with nothing else in it: pydantic's own passes over what is none."""

    @classmethod
    def decode(cls, data: bytes) -> bytes:
        """Return the bytes; PydanticCustomError unless the text is base64."""
        try:
            return base64.b64decode(data, validate=True)
        except ValueError as exc:
            raise PydanticCustomError("no_base64", "is no base64") from exc

    @classmethod
    def encode(cls, value: bytes) -> bytes:
        """Return the bytes as base64."""
        return base64.b64encode(value)

    @classmethod
    def get_json_format(cls) -> Literal["base64"]:
        """Return the name of the encoding in the JSON Schema."""
        return "base64"


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ObservationRecord(_Record):
    """A vertex seen in a view (index), in pixels."""

    view: NonNegativeInt
    uv: Vector2
    cov: tuple[Vector2, Vector2]


class VertexRecord(_Record):
    """A 3-D vertex with its covariance."""

    point: Vector3
    cov: tuple[Vector3, Vector3, Vector3]
    observations: tuple[ObservationRecord, ...] = ()
    label: PositionLabel | None = None


class EdgeRecord(_Record):
    """A straight edge between two vertices (indices)."""

    start: NonNegativeInt
    end: NonNegativeInt
    support: Share = 1.0
    evidence: Evidence = Evidence.MEASURED


class PlaneRecord(_Record):
    """normal · x + offset = 0 with a unit normal; covariance of (normal, offset)."""

    normal: Vector3
    offset: FiniteFloat
    cov: tuple[Vector4, Vector4, Vector4, Vector4]


class FaceSightRecord(_Record):
    """Shares of a face: what a view (index) shows, what faces (indices) hide, what lies outside."""

    view: NonNegativeInt
    seen: Share
    hidden: tuple[tuple[NonNegativeInt, Share], ...] = ()
    outside: Share = 0.0


class FaceRecord(_Record):
    """A flat face: loops of vertices (indices), the outline counter-clockwise from outside."""

    outline: Ring
    plane: PlaneRecord
    holes: tuple[Ring, ...] = ()
    support: Share = 1.0
    coverage: Share = 1.0
    evidence: Evidence = Evidence.MEASURED
    sights: tuple[FaceSightRecord, ...] = ()


class PatchRecord(_Record):
    """Surface that is not flat: points, their outward unit normals (or zeros), areas."""

    points: tuple[Vector3, ...]
    normals: tuple[Vector3, ...]
    areas: tuple[Annotated[FiniteFloat, Field(ge=0.0)], ...]
    hull: tuple[NonNegativeInt, ...] = ()


class BodyRecord(_Record):
    """One object: its faces, edges and patches (indices); whole if known from all sides."""

    faces: tuple[NonNegativeInt, ...] = ()
    edges: tuple[NonNegativeInt, ...] = ()
    patches: tuple[NonNegativeInt, ...] = ()
    whole: bool = False


class SightLinesRecord(_Record):
    """Lines of sight from a place, of a view (index) or none, to points of surfaces.

    `ends` are their coordinates x, y, z one after the other, little-endian float32, in base64.
    """

    origin: Vector3
    ends: Annotated[bytes, EncodedBytes(encoder=_Base64)]
    view: NonNegativeInt | None = None


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
    views: tuple[NonNegativeInt, ...]
    origins: tuple[Vector3, ...]
    shown: Annotated[bytes, EncodedBytes(encoder=_Base64)]
    wrong: Share | None = None
    ground: bool = True


class PosedCameraRecord(_Record):
    """The camera of a view, a pinhole without distortion, and where it stood.

    `size` is width and height, `focal` fx and fy, `middle` cx and cy, px; `rotation` is
    world_from_camera (x right, y down, z forward), `centre` in the world.
    """

    size: tuple[PositiveInt, PositiveInt]
    focal: tuple[FiniteFloat, FiniteFloat]
    middle: tuple[FiniteFloat, FiniteFloat]
    rotation: tuple[Vector3, Vector3, Vector3]
    centre: Vector3


class SceneRecord(_Record):
    """A reconstructed scene: vertices, edges and flat faces with their uncertainty."""

    model_config = ConfigDict(frozen=True, extra="forbid", title=FORMAT)

    format: Literal["facetlog-scene/1"] = Field(alias="schema")
    name: str
    metric: bool = Field(
        default=False, description="lengths are metres; else their unit is unknown"
    )
    up: Vector3 | None = Field(default=None, description="unit vector upwards, if known")
    views: tuple[str, ...] = ()
    vertices: tuple[VertexRecord, ...] = ()
    edges: tuple[EdgeRecord, ...] = ()
    faces: tuple[FaceRecord, ...] = ()
    warnings: tuple[str, ...] = ()
    patches: tuple[PatchRecord, ...] = ()
    bodies: tuple[BodyRecord, ...] = ()
    sights: tuple[SightLinesRecord, ...] = ()
    cameras: tuple[PosedCameraRecord, ...] = Field(
        default=(), description="one for each view, or none"
    )
    lattices: tuple[SeenLatticeRecord, ...] = ()
    scale_sd: FiniteFloat = Field(
        default=0.0,
        ge=0.0,
        lt=1.0,
        description="relative standard deviation of metres, which is in no covariance",
    )
