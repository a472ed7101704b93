"""The bits of a lattice, packed into few bytes, and back, whatever the bytes are."""

import zlib
from math import prod

import numpy as np
from numpy.typing import NDArray

__all__ = ["MOST_LATTICE_BITS", "packed", "unpacked"]

MOST_LATTICE_BITS = 1 << 24
"""Bits of all lattices of a scene that is read: five times what 32 views make."""


def packed(bits: NDArray[np.bool_]) -> bytes:
    """The bits in their order, eight a byte, the first one highest, compressed by zlib."""
    return zlib.compress(np.packbits(bits).tobytes())


def unpacked(content: bytes, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """The bits that were packed, in that shape.

    ValueError if there are others than so many, or none. No more is unpacked than these take.
    """
    count = prod(shape)
    size = -(-count // 8)
    stream = zlib.decompressobj()
    try:
        raw = stream.decompress(content, size + 1)
    except zlib.error as exc:
        raise ValueError("is not compressed by zlib") from exc
    if len(raw) != size or not stream.eof or stream.unused_data:
        raise ValueError(f"does not hold {count} bits")
    return np.unpackbits(np.frombuffer(raw, np.uint8), count=count).view(np.bool_).reshape(shape)
