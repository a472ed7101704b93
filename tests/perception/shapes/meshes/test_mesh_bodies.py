"""Objects of a mesh: which parts are one, and what that takes."""

import tracemalloc

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.meshes.clean_mesh import clean_mesh
from facetlog.perception.shapes.meshes.mesh_bodies import find_bodies


def test_specks_far_apart_are_objects_of_their_own_and_take_little_memory() -> None:
    count = 1000
    places = np.stack(np.meshgrid(*[np.arange(10.0)] * 3), axis=-1).reshape(count, 1, 3)
    specks = places + np.random.default_rng(0).random((count, 3, 3)) * 1e-2
    surface = clean_mesh(Mesh(specks.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)))
    tracemalloc.start()
    bodies = find_bodies(surface)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(set(bodies.tolist())) == count
    assert most < 20e6  # samples of all would take .5 MB each


def test_rubble_whose_pieces_cannot_all_be_compared_is_refused_before_that_takes_memory() -> None:
    count = 20_000
    rubble = np.random.default_rng(0).random((count, 1, 3))
    rubble = rubble + 0.1 * np.random.default_rng(1).random((count, 3, 3))
    surface = clean_mesh(Mesh(rubble.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)))
    tracemalloc.start()
    with pytest.raises(InputError, match=r"falls into 20,000 parts that share no corner, too many"):
        find_bodies(surface)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 200e6  # all pairs near each other would take 1 GB
