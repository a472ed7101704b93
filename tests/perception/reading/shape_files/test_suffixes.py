"""Readers that suffixes.py names are there."""

from pkgutil import resolve_name

import pytest

from facetlog.perception.reading.shape_files import clouds, meshes
from facetlog.perception.reading.shape_files.suffixes import CLOUD_READERS, MESH_READERS

NAMED = sorted(
    {f"{clouds.__name__}.{name}" for name in CLOUD_READERS.values()}
    | {f"{meshes.__name__}.{name}" for name in MESH_READERS.values()}
)


@pytest.mark.parametrize("name", NAMED)
def test_a_reader_that_is_named_is_there(name: str) -> None:
    assert callable(resolve_name(name))
