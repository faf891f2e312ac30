"""The mass of an attached object, against trimesh's integrals over its surface, or sums over its slices."""

import pickle
from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.collision.attached import inertias_of
from ulna.errors import InputError

trimesh = pytest.importorskip("trimesh")
T = ulna.pose((0.02, -0.03, 0.08), rpy=(0.3, -0.4, 1.1))
POINTS = np.random.default_rng(3).uniform((-0.1, -0.2, 0.3), (0.2, 0.1, 0.5), (40, 3))
# What has flat faces, with its surface; and what is round about z, with its pieces from low to high and the square of its radius.
FLAT = {
    "box": (ulna.Box((0.1, 0.2, 0.3)), trimesh.creation.box((0.1, 0.2, 0.3))),
    "convex mesh": (ulna.ConvexMesh(POINTS), trimesh.convex.convex_hull(POINTS)),
}
ROUND = {
    "sphere": (ulna.Sphere(0.1), (-0.1, 0.1), lambda z: 0.01 - z * z),
    "cylinder": (ulna.Cylinder(0.05, 0.3), (-0.15, 0.15), lambda z: 0.0025 + 0 * z),
    "flat cylinder": (ulna.Cylinder(0.3, 0.02), (-0.01, 0.01), lambda z: 0.09 + 0 * z),
    "capsule": (ulna.Capsule(0.05, 0.3), (-0.2, -0.15, 0.15, 0.2), lambda z: 0.0025 - np.maximum(np.abs(z) - 0.15, 0) ** 2),
    "short capsule": (
        ulna.Capsule(0.1, 0.01),
        (-0.105, -0.005, 0.005, 0.105),
        lambda z: 0.01 - np.maximum(np.abs(z) - 0.005, 0) ** 2,
    ),
}
SOLIDS = {name: one[0] for name, one in (FLAT | ROUND).items()}


def by_slices(heights, square):
    """The volume and the tensor of a solid that is round about z, at a density of 1: sums over disks, exact by Gauss."""
    volume, across, along = 0.0, 0.0, 0.0
    nodes, weights = np.polynomial.legendre.leggauss(8)
    for low, high in pairwise(heights):
        z, step = (low + high) / 2 + nodes * (high - low) / 2, weights * (high - low) / 2
        area = np.pi * square(z)
        volume += step @ area
        across += step @ (area * square(z) / 4 + area * z * z)
        along += step @ (area * square(z) / 2)
    return volume, np.diag([across, across, along])


def payload(robot):
    """The inertia of the only object attached, in the frame of its link."""
    (one,) = carried(robot)
    return one


def carried(robot):
    """The inertias of what is attached, each with its link."""
    everything = inertias_of(robot.description, robot.attached)
    own = len(inertias_of(robot.description))
    assert own == sum(link.inertia is not None for link in robot.description.links)
    return everything[own:]


@pytest.mark.parametrize("name", SOLIDS)
def test_a_density_gives_the_mass_the_center_and_the_tensor_of_the_shape(panda, name):
    if name in FLAT:
        surface = FLAT[name][1]
        volume, center, tensor = surface.volume, surface.center_mass, surface.moment_inertia  # at a density of 1
    else:
        center, (volume, tensor) = np.zeros(3), by_slices(*ROUND[name][1:])
    link, inertia = payload(panda.with_attached("part", SOLIDS[name], np.eye(4), link="panda_link7", density=700.0))
    assert link == "panda_link7"
    assert inertia.mass == pytest.approx(700 * volume, rel=1e-12)
    np.testing.assert_allclose(inertia.center, center, rtol=0, atol=1e-12)
    np.testing.assert_allclose(inertia.tensor, 700 * tensor, rtol=0, atol=1e-12 * 700 * tensor.max())


@pytest.mark.parametrize("name", SOLIDS)
def test_a_mass_is_spread_over_the_shape_and_moved_into_the_frame_of_the_link(panda, name):
    shape = SOLIDS[name]
    _, alone = payload(panda.with_attached("part", shape, np.eye(4), density=1.0))
    _, inertia = payload(panda.with_attached("part", shape, T, mass=3.0))
    R = T[:3, :3]
    assert inertia.mass == 3.0
    np.testing.assert_allclose(inertia.center, T[:3, 3] + R @ alone.center, rtol=0, atol=1e-15)
    np.testing.assert_allclose(inertia.tensor, R @ alone.tensor @ R.T * 3.0 / alone.mass, rtol=1e-12, atol=1e-16)


def test_a_box_as_a_convex_mesh_has_the_inertia_of_the_box(panda):
    corners = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, 8).T * (0.05, 0.1, 0.15)
    _, box = payload(panda.with_attached("part", ulna.Box((0.1, 0.2, 0.3)), T, density=900.0))
    _, hull = payload(panda.with_attached("part", ulna.ConvexMesh(corners), T, density=900.0))
    assert hull.mass == pytest.approx(box.mass, rel=1e-13)
    np.testing.assert_allclose(hull.center, box.center, rtol=0, atol=1e-15)
    np.testing.assert_allclose(hull.tensor, box.tensor, rtol=0, atol=1e-15)


def test_a_center_and_a_tensor_that_are_given_are_in_the_frame_of_the_object(panda):
    tensor = np.array([[3.0, 0.1, 0.2], [0.1, 4.0, 0.3], [0.2, 0.3, 5.0]]) * 1e-3
    _, inertia = payload(panda.with_attached("part", ulna.Sphere(0.1), T, mass=2.0, com=(0.1, 0.2, 0.3), inertia=tensor))
    np.testing.assert_allclose(inertia.center, (T @ [0.1, 0.2, 0.3, 1.0])[:3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(inertia.tensor, T[:3, :3] @ tensor @ T[:3, :3].T, rtol=0, atol=1e-17)


def test_it_is_gone_with_the_object_and_survives_a_pickle(panda):
    assert carried(panda) == ()
    holding = panda.with_attached("cup", ulna.Box((0.05,) * 3), T, mass=0.4).with_attached("lid", ulna.Sphere(0.01), T)
    assert len(carried(holding)) == 1  # the lid is weightless
    again = pickle.loads(pickle.dumps(holding))  # noqa: S301 - our own
    np.testing.assert_array_equal(payload(again)[1].tensor, payload(holding)[1].tensor)
    put_down = holding.without_attached("cup")
    assert carried(put_down) == ()
    assert holding.to_urdf() == panda.to_urdf()  # which has no attached objects


def test_shapes_without_volume_are_points_and_rods_and_have_no_density(panda):
    flat = ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)])
    _, inertia = payload(panda.with_attached("part", flat, np.eye(4), mass=1.0))
    np.testing.assert_allclose(inertia.center, (1 / 30, 1 / 30, 0), rtol=0, atol=1e-15)
    _, rod = payload(panda.with_attached("part", ulna.Capsule(0.0, 0.3), np.eye(4), mass=1.0))
    np.testing.assert_allclose(rod.tensor, np.diag([0.0075, 0.0075, 0]), rtol=0, atol=1e-17)
    _, point = payload(panda.with_attached("part", ulna.Capsule(0.0, 0.0), np.eye(4), mass=1.0))
    assert not point.tensor.any()
    for shape in (flat, ulna.Capsule(0.0, 0.3), ulna.Box((0.1, 0.1, 0))):
        with pytest.raises(InputError, match="has no volume; give its mass"):
            panda.with_attached("part", shape, np.eye(4), density=1000.0)


@pytest.mark.parametrize(
    ("given", "argument"),
    [
        ({"density": 0.0}, "density"),
        ({"density": np.inf}, "density"),
        ({"density": 1.0, "mass": 1.0}, "mass"),
        ({"density": 1.0, "com": (0, 0, 0)}, "com"),
        ({"density": 1.0, "inertia": np.eye(3)}, "inertia"),
        ({"mass": -0.1}, "mass"),
        ({"com": (0, 0, 0)}, "com"),
    ],
)
def test_what_does_not_go_together_is_refused(panda, given, argument):
    with pytest.raises(InputError) as refused:
        panda.with_attached("part", ulna.Sphere(0.1), np.eye(4), **given)
    assert refused.value.argument == argument
