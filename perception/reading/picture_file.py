"""Pictures from files: whole ones only, grey, as they are stored.

A decoder fills the missing part of a truncated file with grey and warns only on the terminal. Such
a picture would have false edges, so files are checked for completeness first.
"""

import io
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import cv2
import numpy as np
import PIL.Image

from facetlog.errors import InputError, make_missing_extra_error
from facetlog.perception.types import Image
from facetlog.safe_read import open_regular, read_regular

PICTURE_SUFFIXES = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp", ".heic", ".heif")
"""Suffixes of pictures in folders; a picture that is named is read whatever its suffix."""
KINDS = "JPEG, PNG, TIFF, BMP, WebP, PNM or HEIC"
# Neither turned by EXIF (poses and intrinsics belong to the picture as stored) nor in colour.
DECODE_FLAGS = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
# Of 16 bits the upper 8 are used: pictures of up to 12 bits that were not scaled to 16 would be
# black.
LEAST_OF_16_BITS = 1 << 12
HEIC_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"mif1", b"msf1")
# A picture of a gigapixel, uncompressed.
MOST_BYTES = 1_000_000_000
MOST_PIXELS = 250_000_000
"""The largest cameras have 151 million, phones 200. Decoded it takes some 1 GB, whatever
the size of its file."""
LEAST_SIDE_PX = 9
"""Span of the filters that find edges: a smaller picture shows none."""
# The warning of libjpeg for a picture that has all its markers but not all its data.
DAMAGE = b"Corrupt JPEG data"


def read_picture(path: Path) -> Image:
    """Return the picture as stored, grey, (H, W) uint8; InputError if missing, damaged or tiny."""
    try:
        data = read_regular(path, MOST_BYTES)
    except FileNotFoundError as exc:
        raise InputError(
            f"picture {path} is missing: put it there or remove its pose from the poses file"
        ) from exc
    except OSError as exc:
        raise InputError(f"picture {str(path)!r} cannot be read: {exc.strerror or exc}") from exc
    check = _check_of(data)
    if check is None:
        raise InputError(f"{path} is not a picture: give one as {KINDS}")
    _check_pixels(_read_header_size(io.BytesIO(data)), path)
    if not check(data):
        raise InputError(f"picture {path} is cut off or damaged: copy it again from its source")
    decoded, chatter = (_decode_heic(data, path), b"") if _is_heic(data) else _decode(data)
    if decoded is None or DAMAGE in chatter:
        raise InputError(f"picture {path} is damaged: copy it again from its source")
    height, width = decoded.shape
    if min(height, width) < LEAST_SIDE_PX:
        raise InputError(
            f"picture {path} is {width} x {height} px, too small to show anything: "
            "copy it again from its source"
        )
    image = _reduce_to_eight_bits(decoded, path)
    image.setflags(write=False)
    return image


def turned(image: Image, turns: int) -> Image:
    """Turn a picture (H, W) by so many quarter turns to the right.

    >>> turned(np.array([[1, 2]], np.uint8), 1).tolist()
    [[1], [2]]
    """
    return np.ascontiguousarray(np.rot90(image, -turns)) if turns else image


def stored_size(path: Path) -> tuple[int, int] | None:
    """Return the width and height that a picture's header states, in px; None where that cannot be
    read.

    InputError where it is more than is decoded.
    """
    try:
        with open_regular(path, MOST_BYTES) as file:
            size = _read_header_size(file)
    except OSError:  # reported when it is read
        return None
    _check_pixels(size, path)
    return size


@contextmanager
def _opened(file: BinaryIO) -> Iterator[PIL.Image.Image]:
    """Open a picture by Pillow, which reads its header alone; any exception where it is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of large pictures, or of odd headers
        limit, PIL.Image.MAX_IMAGE_PIXELS = PIL.Image.MAX_IMAGE_PIXELS, None  # see _check_pixels
        try:
            with PIL.Image.open(file) as picture:
                yield picture
        finally:
            PIL.Image.MAX_IMAGE_PIXELS = limit


def _read_header_size(file: BinaryIO) -> tuple[int, int] | None:
    try:
        with _opened(file) as picture:
            return picture.size
    except Exception:
        return None


def _check_pixels(size: tuple[int, int] | None, path: Path) -> None:
    if size is not None and size[0] * size[1] > MOST_PIXELS:
        raise InputError(
            f"picture {path} is {size[0]} x {size[1]} by its header, more than "
            f"{MOST_PIXELS // 1_000_000} million pixels: make it smaller"
        )


def _reduce_to_eight_bits(decoded: cv2.typing.MatLike, path: Path) -> Image:
    """Return grey levels of 8 bits; InputError where 16 bits are hardly used, or levels are no
    integers.

    The range that is used must be the same for all pictures of a set: it is not guessed.
    """
    if decoded.dtype == np.uint8:
        return np.ascontiguousarray(decoded, dtype=np.uint8)
    if decoded.dtype != np.uint16:
        raise InputError(
            f"picture {path} has levels of {decoded.dtype}: write it with 8 or 16 bits"
        )
    brightest = int(decoded.max(initial=0))
    if 0 < brightest < LEAST_OF_16_BITS:
        raise InputError(
            f"picture {path} has 16 bits, yet no level above {LEAST_OF_16_BITS - 1}: "
            "write it with 8 bits, or with levels up to 65535"
        )
    return np.ascontiguousarray(np.asarray(decoded) // 256, dtype=np.uint8)


def _check_of(data: bytes) -> Callable[[bytes], bool] | None:
    """Return the completeness check for the kind of file, None for an unknown kind."""
    for signature, check in (
        (b"\xff\xd8\xff", _is_whole_jpeg),
        (b"\x89PNG\r\n\x1a\n", _is_whole_png),
        (b"BM", _is_whole_bmp),
        (b"II*\0", _is_checked_by_decoder),
        (b"MM\0*", _is_checked_by_decoder),
    ):
        if data.startswith(signature):
            return check
    if _is_heic(data):
        return _is_checked_by_decoder
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _is_whole_riff
    if data[:1] == b"P" and data[1:2] in tuple(b"%d" % i for i in range(1, 7)):
        return _is_whole_pnm
    return None


def _is_whole_jpeg(data: bytes) -> bool:
    """Return whether the chain of JPEG markers reads from SOI to EOI (ITU-T T.81, annex B)."""
    at = 2
    while at + 1 < len(data):
        if data[at] != 0xFF:
            return False
        marker = data[at + 1]
        if marker == 0xD9:  # EOI
            return True
        if marker == 0xFF:  # fill byte
            at += 1
            continue
        if marker == 0x01 or 0xD0 <= marker <= 0xD7:  # TEM, RSTn: no length
            at += 2
            continue
        if at + 4 > len(data):
            return False
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        if marker == 0xDA:  # SOS: entropy-coded data up to the next marker that is not RSTn
            at = _find_scan_end(data, at)
    return False


def _find_scan_end(data: bytes, at: int) -> int:
    while (at := data.find(b"\xff", at)) >= 0:
        follower = data[at + 1 : at + 2]
        # FF00 is a stuffed data byte, FFD0..FFD7 are restarts inside the scan.
        if follower and follower != b"\0" and not b"\xd0" <= follower <= b"\xd7":
            return at
        at += 2
    return len(data)


def _is_whole_png(data: bytes) -> bool:
    """Return whether all PNG chunks up to IEND are there and their checksums agree."""
    return _passes_point(data, PIL.Image.Image.verify)


def _is_whole_bmp(data: bytes) -> bool:
    return len(data) >= max(int.from_bytes(data[2:6], "little"), 26)


def _is_whole_riff(data: bytes) -> bool:
    return len(data) >= int.from_bytes(data[4:8], "little") + 8


def _is_whole_pnm(data: bytes) -> bool:
    """Return whether a PNM has as many samples as its header requires."""
    return _passes_point(data, PIL.Image.Image.load)


def _passes_point(data: bytes, check: Callable[[PIL.Image.Image], object]) -> bool:
    try:
        with _opened(io.BytesIO(data)) as picture:
            check(picture)
    except Exception:
        return False
    return True


def _is_checked_by_decoder(data: bytes) -> bool:
    return bool(data)


def _is_heic(data: bytes) -> bool:
    return data[4:8] == b"ftyp" and data[8:12] in HEIC_BRANDS


def _decode_heic(data: bytes, path: Path) -> cv2.typing.MatLike | None:
    """Return the picture of a HEIC file, grey, or None; InputError without the package that reads
    it.

    Its own transformations are part of the picture as stored: whoever reads it turns it by these.
    """
    try:
        import pillow_heif
    except ImportError:
        raise make_missing_extra_error(
            f"{path.name}: HEIC pictures", "pillow-heif", "heic"
        ) from None
    try:
        found = np.asarray(pillow_heif.open_heif(data, convert_hdr_to_8bit=True))
    except (OSError, ValueError, RuntimeError, SyntaxError):
        return None
    if found.ndim == 2:
        return found
    code = cv2.COLOR_RGBA2GRAY if found.shape[2] == 4 else cv2.COLOR_RGB2GRAY
    return cv2.cvtColor(np.ascontiguousarray(found), code)


def _decode(data: bytes) -> tuple[cv2.typing.MatLike | None, bytes]:
    """Return the decoded picture, or None, and what the decoders wrote to the terminal meanwhile.

    The C libraries inside OpenCV write to file descriptor 2 with no switch to stop them, so it
    leads to a temporary file for the time of the call.
    """
    buffer = np.frombuffer(data, dtype=np.uint8)
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        terminal = os.dup(2)
    except OSError:  # started without a stderr
        return _decode_image(buffer), b""
    with tempfile.TemporaryFile() as sink:
        os.dup2(sink.fileno(), 2)
        try:
            image = _decode_image(buffer)
        finally:
            os.dup2(terminal, 2)
            os.close(terminal)
        sink.seek(0)
        return image, sink.read()


def _decode_image(buffer: np.ndarray[tuple[int], np.dtype[np.uint8]]) -> cv2.typing.MatLike | None:
    try:
        image = cv2.imdecode(buffer, DECODE_FLAGS)
    except cv2.error:
        return None
    return None if image is None or image.ndim != 2 else image
