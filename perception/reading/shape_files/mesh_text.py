"""Mesh files rewritten for trimesh: UTF-8, no bytes after the end, OBJ with absolute indices.

trimesh counts a negative index of an OBJ from the file's end, the format from the line that has it;
and an index 0, which there is none of, it takes for the first vertex.
"""

import io
import re
from collections.abc import Iterator, Sequence
from typing import BinaryIO

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.mesh_checks import binary_stl_bytes

__all__ = ["readable"]

END_OF_PLY_HEADER = b"end_header"
# What trimesh misreads: a face with an index that does not begin with 1 to 9, a line continued in
# the next, and one that is indented or has tabs.
ODD_FACE = re.compile(rb"\nf(?: ++[1-9]\S*+)*+ ++[-+0]")
CONTINUED = re.compile(rb"\\\r?\n")
ODD_BLANKS = re.compile(rb"\n(?:[ \t]++[vf][ \t]|[vf]\t|f[^\n\t]*+\t)")


def readable(file: BinaryIO, name: str, kind: str) -> BinaryIO:
    """The same mesh in a form that trimesh reads correctly; the file itself if it already is.

    Text that is not UTF-8 is taken for Latin-1: only comments and names differ. Raises InputError
    for an OBJ with an index that is none.
    """
    match kind:
        case "ply":
            return _ply(file)
        case "stl":
            needed = binary_stl_bytes(file)
            held = file.seek(0, io.SEEK_END)
            file.seek(0)
            if needed == held:
                return file
            return _text(file.read()) if needed is None else io.BytesIO(file.read(needed))
        case "off":
            return _text(file.read())
        case "obj":
            data = file.read()
            odd = any(form.search(data) for form in (ODD_FACE, CONTINUED, ODD_BLANKS))
            return _text(b"".join(_plain_obj(data, name)) if odd else data)
    return file


def _text(data: bytes) -> BinaryIO:
    if not data.isascii():
        try:
            data.decode("utf-8")
        except UnicodeDecodeError:
            data = data.decode("latin-1").encode("utf-8")
    return io.BytesIO(data)


def _ply(file: BinaryIO) -> BinaryIO:
    """With a header in ASCII: others stand in its comments alone."""
    head = bytearray()
    for line in file:
        head += line
        if line.startswith(END_OF_PLY_HEADER):
            break
    if head.isascii():
        file.seek(0)
        return file
    return io.BytesIO(head.decode("latin-1").encode("ascii", "replace") + file.read())


def _plain_obj(data: bytes, name: str) -> Iterator[bytes]:
    """Vertices and faces alone, a line each, with absolute indices of vertices."""
    count = 0
    for number, line in _logical_lines(data):
        words = (line.partition(b"#")[0] if b"#" in line else line).split()
        if words[:1] == [b"v"]:
            count += 1
            yield b" ".join(words) + b"\n"
        elif words[:1] == [b"f"]:
            corners = _absolute(words[1:], count, f"{name}: line {number}")
            yield b"f " + b" ".join([b"%d" % corner for corner in corners]) + b"\n"


def _logical_lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    r"""Lines by the number of their first, those that end in \ with the next; comments never do."""
    start, held = 0, b""
    for number, line in enumerate(data.splitlines(), 1):
        start = start if held else number
        whole = held + line
        if line.endswith(b"\\") and not whole.lstrip().startswith(b"#"):
            held = whole[:-1] + b" "
            continue
        held = b""
        yield start, whole
    if held:
        yield start, held


def _absolute(words: Sequence[bytes], count: int, place: str) -> list[int]:
    """The vertices of corners v/vt/vn, from 1; negative ones count back from the `count` so far."""
    try:
        corners = [int(word.partition(b"/")[0]) for word in words]
    except ValueError:
        line = b" ".join(words).decode("latin-1")
        raise InputError(f"{place}: f {line:.40}: is no face; export the mesh again") from None
    if 0 in corners:
        raise InputError(f"{place}: vertex 0: indices of an OBJ begin at 1; export the mesh again")
    least = min(corners, default=1)
    if least > 0:
        return corners
    if least < -count:
        raise InputError(
            f"{place}: vertex {least}: there are {count} before it; export the mesh again"
        )
    return [corner if corner > 0 else count + 1 + corner for corner in corners]
