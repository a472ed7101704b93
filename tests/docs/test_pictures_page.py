"""docs/pictures.md names the files of every kind of poses."""

import re
from pathlib import Path

import pytest

from facetlog.perception.reading.pose_files.pose_reader import PoseReader
from facetlog.perception.reading.pose_files.register import READERS

PAGE = (Path(__file__).parents[2] / "docs" / "pictures.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.kind)
def test_the_page_names_what_a_kind_of_poses_needs(reader: PoseReader) -> None:
    files = re.findall(r"\w+\.\w+", reader.needs)
    assert [name for name in files if name not in PAGE] == []
    assert files or reader.kind.split()[0] in PAGE
