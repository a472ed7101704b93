"""Bits come back as they went in; other bytes are refused, and not unpacked beyond what is due."""

import tracemalloc
import zlib
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import NDArray

from facetlog.perception.surfaces.scene_file import pack_bits, unpack_bits


@given(arrays(np.bool_, array_shapes(max_dims=3)))
def test_bits_come_back(bits: NDArray[np.bool_]) -> None:
    back = unpack_bits(pack_bits(bits), bits.shape)
    assert back.dtype == np.bool_
    assert back.tolist() == bits.tolist()


@given(st.binary(max_size=40))
def test_other_bytes_are_refused_or_hold_the_bits(content: bytes) -> None:
    with suppress(ValueError):
        assert unpack_bits(content, (3, 4)).shape == (3, 4)


def test_what_would_fill_the_memory_is_not_unpacked() -> None:
    bomb = zlib.compress(bytes(50_000_000))
    tracemalloc.start()
    with pytest.raises(ValueError, match="does not hold 8 bits"):
        unpack_bits(bomb, (2, 2, 2))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1_000_000
