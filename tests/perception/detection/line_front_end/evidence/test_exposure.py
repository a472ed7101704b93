"""By how much a picture is brighter than the others."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.evidence.exposure import exposures
from facetlog.perception.types import View
from tests.perception.detection.line_front_end.block_rig import block_rig


def dimmed(view: View, by: float) -> View:
    return replace(view, image=np.rint(by * view.image).astype(np.uint8))


def test_a_picture_that_was_exposed_for_less_time_is_darker_by_as_much() -> None:
    rig = block_rig()
    views = [dimmed(rig.views[0], 0.6), *rig.views[1:4], dimmed(rig.views[4], 0.8), *rig.views[5:]]
    found = exposures(rig.edges, rig.shown_edges.astype(np.bool_), views)
    assert found[0] == pytest.approx(0.6, rel=0.03)
    assert found[4] == pytest.approx(0.8, rel=0.03)
    np.testing.assert_allclose(np.delete(found, [0, 4]), 1.0, rtol=0.03)
