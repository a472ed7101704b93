"""Values own their arrays: nothing that is written elsewhere changes them."""

import numpy as np
import pytest

from facetlog.perception.scene import Vertex


def test_what_can_be_written_to_is_copied() -> None:
    point = np.zeros(3)
    seen = point[:]
    seen.setflags(write=False)  # writing to what it is cut from changes it
    vertices = Vertex(point, np.eye(3)), Vertex(seen, np.eye(3))
    point[0] = 1.0
    assert [v.point[0] for v in vertices] == [0.0, 0.0]


def test_what_cannot_be_written_to_is_kept() -> None:
    points = np.zeros((2, 3))
    points.setflags(write=False)
    assert Vertex(points[0], np.eye(3)).point.base is points
    assert not Vertex(np.zeros(3), np.eye(3)).point.flags.writeable


def test_a_wrong_shape_is_refused_whether_copied_or_kept() -> None:
    flat = np.zeros(2)
    with pytest.raises(ValueError, match="expected shape"):
        Vertex(flat, np.eye(3))
    flat.setflags(write=False)
    with pytest.raises(ValueError, match="expected shape"):
        Vertex(flat, np.eye(3))
