"""Buffers, views and accessors of a glTF 2.0: their bytes, compared with what is claimed of them.

A document of a few bytes can ask for terabytes; nothing is fetched, and no file outside the
folder is opened.
"""

import base64
import binascii
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.file_damage import describe_claim, describe_truncation
from facetlog.perception.reading.shape_files.file_text import to_plain_bytes
from facetlog.perception.reading.shape_files.meshes.mesh_checks import Limits
from facetlog.perception.types import FloatArray

__all__ = ["COMPRESSED", "GltfData", "is_compressed", "read_document"]

GLB_MAGIC, GLB_JSON, GLB_BINARY = b"glTF", 0x4E4F534A, 0x004E4942
# glTF 2.0, tables in 3.6.2.2: types of a component, components of an element.
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
# Extensions that keep geometry in other ways than accessors do.
COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}


def read_document(path: Path, data: bytes, kind: str) -> tuple[dict[str, Any], bytes | None]:
    """Return the JSON of a glTF, and the binary chunk of a GLB (None where there is none)."""
    name = path.name
    binary = None
    chunks = data[:4] == GLB_MAGIC
    if chunks:
        data, binary = _read_chunks(data, name)
    text = to_plain_bytes(data).lstrip()
    if not text.startswith(b"{"):
        what = "GLB header" if kind == "glb" and not chunks else "JSON object"
        shown = text[:30].decode("utf-8", "replace").partition("\n")[0]
        begins = f", it begins with {shown}" if shown.isprintable() and shown else ""
        raise InputError(f"{name}: has no {what}{begins}; export the mesh again")
    try:
        document: dict[str, Any] = json.loads(text)
    except (ValueError, RecursionError) as exc:
        raise InputError(
            f"{name}: is no glTF, its JSON is truncated or damaged ({exc!s:.80}); export it again"
        ) from exc
    return document, binary


def is_compressed(name: str, extension: str) -> InputError:
    """Return the error of geometry that is kept by an extension of `COMPRESSED`."""
    return InputError(
        f"{name}: is compressed with {COMPRESSED[extension]} ({extension}); export it without "
        "compression"
    )


def _read_chunks(data: bytes, name: str) -> tuple[bytes, bytes | None]:
    if len(data) < 20:
        raise describe_truncation(name, "ends within its GLB header")
    version, total, length, chunk = struct.unpack("<4xIIII", data[:20])
    if version != 2:
        raise InputError(f"{name}: is glTF {version}.0, which is not read; convert it to glTF 2.0")
    if total > len(data) or 20 + length > len(data) or chunk != GLB_JSON:
        raise describe_claim(name, f"{max(total, 20 + length)} bytes")
    place, binary = 20 + length, None
    while place + 8 <= total and binary is None:
        size, chunk = struct.unpack("<II", data[place : place + 8])
        if place + 8 + size > total:
            raise describe_claim(name, f"a chunk of {size} bytes")
        if chunk == GLB_BINARY:
            binary = data[place + 8 : place + 8 + size]
        place += 8 + size
    return data[20 : 20 + length], binary


@dataclass(slots=True)
class GltfData:
    """The numbers that a glTF's accessors hold."""

    document: dict[str, Any]
    path: Path
    binary: bytes | None
    limits: Limits
    _buffers: dict[int, bytes] = field(default_factory=dict)
    _zeros: int = 0

    def read(self, index: int) -> FloatArray:
        """Return the elements (count, width) of an accessor; normalised integers as -1 to 1."""
        accessor = self.document["accessors"][index]
        count, width = accessor["count"], WIDTHS[accessor["type"]]
        component = np.dtype(COMPONENTS[accessor["componentType"]])
        if not isinstance(count, int) or count < 0:
            raise ValueError(f"an accessor of {count} elements")
        if "bufferView" in accessor:
            raw = self._elements(accessor, count, width, component).astype(np.float64)
        else:
            # zeros (3.6.2.1), with `sparse` all but a few
            self._zeros += count
            if self._zeros > 3 * self.limits.triangles:
                raise describe_claim(self.path.name, f"{count} values in 0 bytes")
            raw = np.zeros((count, width))
        if "sparse" in accessor:
            self._replace_sparse(raw, accessor["sparse"], width, component)
        if accessor.get("normalized") and component.kind in "iu":
            # 3.6.2.2: f = max(c / 127, -1) and the like
            raw = np.maximum(raw / np.iinfo(component).max, -1.0)
        return raw

    def step(self, index: int) -> float:
        """Return the distance of neighbouring values of an accessor; 0 where they are floats."""
        accessor = self.document["accessors"][index]
        component = np.dtype(COMPONENTS[accessor["componentType"]])
        if component.kind not in "iu":
            return 0.0
        return 1.0 / float(np.iinfo(component).max) if accessor.get("normalized") else 1.0

    def _replace_sparse(
        self, raw: FloatArray, sparse: dict[str, Any], width: int, component: np.dtype[Any]
    ) -> None:
        count = sparse["count"]
        kind = np.dtype(COMPONENTS[sparse["indices"]["componentType"]])
        at = self._elements(sparse["indices"], count, 1, kind).astype(np.int64).ravel()
        raw[at] = self._elements(sparse["values"], count, width, component)

    def _elements(
        self, part: dict[str, Any], count: int, width: int, component: np.dtype[Any]
    ) -> np.ndarray[Any, Any]:
        view = self.document["bufferViews"][part["bufferView"]]
        data = self._view_bytes(view)
        start, element = part.get("byteOffset", 0), width * component.itemsize
        stride = view.get("byteStride", element) or element
        if count and (start < 0 or start + stride * (count - 1) + element > len(data)):
            raise describe_claim(self.path.name, f"{count} values in {len(data)} bytes")
        if count == 0:
            return np.zeros((0, width), dtype=component)
        return np.ndarray((count, width), component, data, start, (stride, component.itemsize))

    def _view_bytes(self, view: dict[str, Any]) -> memoryview:
        index, start, length = view["buffer"], view.get("byteOffset", 0), view["byteLength"]
        try:
            buffer = self._buffer(index)
        except InputError:
            compressed = [key for key in COMPRESSED if key in view.get("extensions", {})]
            if not compressed:
                raise
            raise is_compressed(self.path.name, compressed[0]) from None
        if start < 0 or length < 0 or start + length > len(buffer):
            raise describe_claim(self.path.name, f"a view of {length} bytes")
        return memoryview(buffer)[start : start + length]

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            self._buffers[index] = self._load_buffer(self.document["buffers"][index], index)
        return self._buffers[index]

    def _load_buffer(self, buffer: dict[str, Any], index: int) -> bytes:
        name, uri = self.path.name, buffer.get("uri")
        if uri is None:
            if self.binary is None or index != 0:
                raise InputError(f"{name}: buffer {index} has no data; export the mesh again")
            return self.binary
        if uri.startswith("data:"):
            try:
                return base64.b64decode(unquote(uri.partition(",")[2]), validate=True)
            except binascii.Error as exc:
                raise InputError(f"{name}: has a damaged buffer; export it again") from exc
        folder = self.path.resolve().parent
        target = (folder / unquote(uri)).resolve()
        if "://" in uri or not target.is_relative_to(folder):
            raise InputError(
                f"{name}: points outside its folder ({uri[:80]}); put the data beside it"
            )
        if target.exists() and not target.is_file():
            raise InputError(f"{name}: {uri[:80]} is no regular file; put the data itself there")
        if not target.is_file():
            raise InputError(f"{name}: {uri[:80]} is missing; put it beside the glTF")
        if target.stat().st_size > self.limits.size_bytes:
            raise InputError(f"{name}: {uri[:80]} is too large; reduce the mesh")
        return target.read_bytes()
