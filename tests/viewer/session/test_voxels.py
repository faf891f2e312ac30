"""The voxels of a map, without a page."""

from types import SimpleNamespace

import numpy as np
import pytest

from ulna.viewer.session.voxels import Voxels


@pytest.fixture
def voxels():
    """Four cubes of 0.1 m along x, the second of which nothing reaches, and one above the last."""
    share = np.zeros((2, 1, 4))
    share[0, 0] = [0.25, 0.0, 0.5, 1.0]
    share[1, 0, 3] = 0.75
    axes = np.array([0.05, 0.15]), np.array([0.05]), np.array([0.05, 0.15, 0.25, 0.35])
    return Voxels(SimpleNamespace(share=SimpleNamespace(values=share), grid=SimpleNamespace(axes=axes, voxel=0.1)))


def test_only_what_is_reached_is_there(voxels):
    np.testing.assert_allclose(voxels.centers, [(0.05, 0.05, 0.05), (0.25, 0.05, 0.05), (0.35, 0.05, 0.05), (0.35, 0.05, 0.15)])
    assert voxels.shares.tolist() == [0.25, 0.5, 1.0, 0.75]


def test_a_plane_and_a_least_share_choose(voxels):
    assert voxels.ends("x") == pytest.approx((0.0, 0.4))
    assert voxels.shown("x", 0.0, 0.0).tolist() == [0, 1, 2, 3]
    assert voxels.shown("x", 0.2, 0.0).tolist() == [1, 2, 3]
    assert voxels.shown("x", 0.2, 0.6).tolist() == [2, 3]
    assert voxels.shown("z", 0.1, 0.0).tolist() == [3]


def test_more_orientations_are_lighter(voxels):
    lightness = voxels.colors @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness[np.argsort(voxels.shares)]) > 0).all()


@pytest.mark.parametrize(
    ("origin", "direction", "hit"),
    [
        ((-1, 0.05, 0.05), (1, 0, 0), 0),
        ((1, 0.05, 0.05), (-1, 0, 0), 2),
        ((1, 0.05, 0.15), (-2, 0, 0), 3),
        ((0.15, 0.05, 5), (0, 0, -1), None),  # through the gap
        ((0.15, 0.05, 0.05), (1, 0, 0), 1),  # from within the gap: what lies behind is not hit
        ((-1, 0.05, 0.2001), (1, 0, 0), None),
        ((-1, 0.05, 0.1999), (1, 0, 0), 3),
        ((-0.1, 0.05, -0.1), (1, 0, 1), 0),
        ((5, 5, 5), (1, 1, 1), None),
    ],
)
def test_the_first_voxel_on_a_ray_is_found(voxels, origin, direction, hit):
    assert voxels.on_ray(np.array(origin, float), np.array(direction, float), np.arange(4)) == hit


def test_what_is_not_shown_is_not_hit(voxels):
    ray = np.array([-1, 0.05, 0.05]), np.array([1.0, 0, 0])
    assert voxels.on_ray(*ray, voxels.shown("x", 0.2, 0.0)) == 1
    assert voxels.on_ray(*ray, np.empty(0, dtype=int)) is None
