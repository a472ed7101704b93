"""Views of one kind of poses file beside those of another."""

import numpy as np

from facetlog.perception.types import View


def same_views(found: tuple[View, ...], wanted: tuple[View, ...]) -> None:
    """Fails unless poses, cameras and pixels are the same."""
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose(one.pose.rotation, other.pose.rotation, atol=1e-12)
        np.testing.assert_allclose(one.pose.centre, other.pose.centre, atol=1e-12)
        assert one.camera == other.camera
        np.testing.assert_array_equal(one.image, other.image)
