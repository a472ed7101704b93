import cv2
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.special import erf

from facetlog.perception.detection.block_front_end.edge_lines import (
    cut_straight_pieces,
    find_edge_pixels,
    fit_edge_line,
)
from facetlog.perception.detection.block_front_end.faces_of_block import picture_features
from facetlog.perception.detection.block_front_end.plane_regions import plane_regions


def matched(found, truth, within=3.0):
    """Pairs (found index, true index) within a distance."""
    distance = np.linalg.norm(found[:, None] - truth[None], axis=2)
    rows, columns = linear_sum_assignment(np.minimum(distance, 100.0))
    return [(i, j) for i, j in zip(rows, columns, strict=True) if distance[i, j] <= within]


def step_edge(angle_deg, offset, contrast=80.0, noise=0.0, seed=0):
    """A blurred straight step through the picture's middle, and the piece along it."""
    v, u = np.mgrid[0:100, 0:100].astype(float)
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    across = -(u - 50) * s + (v - 50) * c - offset
    fine = 100 + contrast * 0.5 * (1 + erf(across / 2**0.5))
    image = fine + np.random.default_rng(seed).normal(0, noise, fine.shape)
    along = np.linspace(-30, 30, 61)[:, None]
    piece = np.array([50.0, 50.0]) + along * [c, s]
    return np.clip(np.rint(image), 0, 255).astype(np.uint8), piece, np.array([-s, c])


@pytest.mark.parametrize("angle", [0, 20, 160])
@pytest.mark.parametrize("offset", [-0.9, 0.3])
def test_an_edge_line_is_placed_to_a_fiftieth_of_a_pixel(angle, offset):
    image, piece, normal = step_edge(angle, offset)
    line = fit_edge_line(image, piece, 0.3)
    assert line is not None
    assert normal @ (line.middle - [50, 50]) == pytest.approx(offset, abs=0.02)
    assert line.contrast == pytest.approx(80, rel=0.1)


def test_the_variance_of_an_edge_line_is_honest():
    squares = []
    for seed in range(150):
        image, piece, normal = step_edge(25, 0.3, contrast=60, noise=5, seed=seed)
        line = fit_edge_line(image, piece, 5.0)
        foot = normal @ (line.middle - [50, 50]) - 0.3
        squares.append(foot**2 / line.cov[0, 0])
    assert 0.75 < np.mean(squares) < 1.35


def test_a_slope_change_of_thirty_degrees_cuts_and_less_does_not():
    def bent(degrees):
        first = np.column_stack([np.arange(40), np.zeros(40)])
        way = np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])
        return np.concatenate([first, first[-1] + np.arange(1, 40)[:, None] * way])

    assert len(cut_straight_pieces(bent(40), 8)) == 2
    assert len(cut_straight_pieces(bent(1), 8)) == 1


def test_pure_noise_has_hardly_an_edge():
    rng = np.random.default_rng(0)
    image = np.clip(np.rint(rng.normal(180, 5, (240, 320))), 0, 255).astype(np.uint8)
    edges = find_edge_pixels(image, np.full(image.shape, 255, np.uint8))
    assert edges.mean() < 1e-4


def test_the_vertices_of_a_block_are_found_to_a_fraction_of_a_pixel(tour):
    hits = found = true = 0
    errors, squares = [], []
    for view, pixels, visible in zip(tour.views, tour.pixels, tour.visible, strict=True):
        vertices = picture_features(view.image).vertices
        uv = np.array([v.uv for v in vertices])
        found, true = found + len(uv), true + len(visible)
        for i, j in matched(uv, pixels[list(visible)]):
            hits += 1
            error = uv[i] - pixels[visible[j]]
            errors.append(np.hypot(*error))
            squares.append(error @ np.linalg.solve(vertices[i].cov, error))
    assert hits / true > 0.85
    assert hits / found > 0.95
    assert np.median(errors) < 0.12
    assert np.median(squares) / (2 * np.log(2)) < 2.5


def test_each_face_of_a_block_is_one_region(tour):
    view, pixels = tour.views[1], tour.pixels[1]
    features = picture_features(view.image)
    regions = plane_regions(view.image, features.object.mask)
    assert regions.count == 3
    top = np.zeros(view.image.shape, np.uint8)
    cv2.fillPoly(top, [np.rint(pixels[[4, 5, 7, 6]]).astype(np.int32)], 1)
    labels, counts = np.unique(
        regions.labels[cv2.erode(top, np.ones((5, 5))) > 0], return_counts=True
    )
    assert counts.max() / counts.sum() > 0.98
    assert labels[counts.argmax()] > 0


@pytest.mark.parametrize("grey", [0, 149, 255])
def test_a_picture_of_one_grey_has_no_vertices(grey):
    for threshold in (150, None):
        features = picture_features(np.full((120, 160), grey, np.uint8), threshold=threshold)
        assert not features.vertices
        assert not features.object


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (8, 8)])
def test_tiny_pictures_are_no_error(shape):
    image = np.random.default_rng(0).integers(0, 256, shape).astype(np.uint8)
    assert picture_features(image).vertices == ()


def test_a_cut_block_has_no_vertices_on_the_rim_of_the_picture(draw_block):
    scene = draw_block((30.0,))
    image, cut = scene.views[0].image, 150
    features = picture_features(np.ascontiguousarray(image[:, :cut]))
    assert features.object
    assert features.vertices
    truth = scene.pixels[0][list(scene.visible[0])]
    for vertex in features.vertices:
        assert vertex.uv[0] < cut - 1 - 2.0
        assert np.linalg.norm(truth - vertex.uv, axis=1).min() < 3.0


def test_random_pictures_are_no_error():
    rng = np.random.default_rng(3)
    for smoothing in (0.5, 2.0, 8.0):
        image = cv2.GaussianBlur(rng.normal(0, 1, (120, 160)), (0, 0), smoothing)
        image = 128 + 100 * image / np.abs(image).max()
        picture_features(image.astype(np.uint8))
        picture_features(image.astype(np.uint8), threshold=None)
