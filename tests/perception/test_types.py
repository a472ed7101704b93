"""Values own their arrays: nothing that is written elsewhere changes them."""

import numpy as np
import pytest

from facetlog.perception.scene import Vertex


def test_arrays_are_copied_unless_nobody_can_write_to_them() -> None:
    point = np.zeros(3)
    seen = point[:]
    seen.setflags(write=False)  # writing to what it is cut from changes it
    vertices = Vertex(point, np.eye(3)), Vertex(seen, np.eye(3))
    point[0] = 1.0
    assert [v.point[0] for v in vertices] == [0.0, 0.0]
    assert not vertices[0].point.flags.writeable
    points = np.zeros((2, 3))
    points.setflags(write=False)
    assert Vertex(points[0], np.eye(3)).point.base is points
    for flat in (np.zeros(2), points[0, :2]):
        with pytest.raises(ValueError, match="expected shape"):
            Vertex(flat, np.eye(3))
