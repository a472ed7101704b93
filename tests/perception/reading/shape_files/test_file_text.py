"""Text of any usual encoding and line end is read as the same text."""

import codecs

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.reading.shape_files.file_text import (
    to_plain_bytes,
)

LINES = ["# Größe", "v 1.5 -2 3e-4", "f 1 2 3", ""]
ENCODINGS = {
    "utf-8": b"",
    "utf-8 with mark": codecs.BOM_UTF8,
    "utf-16-le": codecs.BOM_UTF16_LE,
    "utf-16-be": codecs.BOM_UTF16_BE,
    "utf-32-le": codecs.BOM_UTF32_LE,
    "utf-16-le without mark": b"",
    "latin-1": b"",
}


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends_do_not_matter(encoding: str, end: str) -> None:
    data = ENCODINGS[encoding] + end.join(LINES).encode(encoding.split()[0])
    assert to_plain_bytes(data).decode().split("\n") == LINES


def test_plain_text_is_not_copied() -> None:
    data = b"v 1 2 3\n"
    assert to_plain_bytes(data) is data


@given(st.binary(max_size=60))
def test_any_bytes_have_a_text(data: bytes) -> None:
    assert "\r" not in to_plain_bytes(data).decode()
