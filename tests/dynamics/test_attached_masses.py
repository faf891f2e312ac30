"""A payload weighs on the joints as a force at its center of mass does, by the transposed Jacobian."""

import numpy as np
import pytest

import ulna

T = ulna.pose((0.05, -0.02, 0.1), rpy=(0.2, 0.4, -0.3))
GIVEN = {
    "an object": lambda robot: robot.with_attached("part", ulna.Box((0.1, 0.2, 0.3)), T, mass=3.0, com=(0.01, 0.02, 0.03)),
    "a density": lambda robot: robot.with_attached("part", ulna.Box((0.1, 0.1, 0.1)), T, density=3000.0),
    "a tool": lambda robot: robot.with_tool(T, mass=3.0, com=(0.01, 0.02, 0.03)),
}


@pytest.mark.parametrize("name", GIVEN)
def test_its_weight_is_that_of_a_force_at_its_center(panda, rng, name):
    loaded, com = GIVEN[name](panda), (0.0, 0.0, 0.0) if name == "a density" else (0.01, 0.02, 0.03)
    for q in rng.uniform(panda.lower, panda.upper, (20, 7)):
        flange, J = panda.forward_kinematics(q), panda.jacobian(q)
        force, arm = np.array([0, 0, 3.0 * 9.81]), flange[:3, :3] @ (T @ [*com, 1.0])[:3]
        expected = J[:3].T @ force + J[3:].T @ np.cross(arm, force)
        np.testing.assert_allclose(loaded.gravity_torque(q) - panda.gravity_torque(q), expected, rtol=0, atol=1e-11)


def test_put_down_it_weighs_nothing(panda):
    holding = GIVEN["an object"](panda)
    assert not np.allclose(holding.gravity_torque(panda.home), panda.gravity_torque(panda.home))
    put_down = holding.without_attached("part")
    np.testing.assert_array_equal(put_down.gravity_torque(panda.home), panda.gravity_torque(panda.home))


def test_an_even_box_turns_as_heavily_as_its_tensor_says(panda):
    point = panda.with_attached("part", ulna.Box((0.1, 0.2, 0.3)), T, mass=3.0, inertia=np.zeros((3, 3)))
    even = panda.with_attached("part", ulna.Box((0.1, 0.2, 0.3)), T, mass=3.0)
    tensor = 3.0 / 12 * np.diag([0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04])
    R, J = panda.forward_kinematics(panda.home)[:3, :3] @ T[:3, :3], panda.jacobian(panda.home)[3:]
    more = even.mass_matrix(panda.home) - point.mass_matrix(panda.home)
    np.testing.assert_allclose(more, J.T @ R @ tensor @ R.T @ J, rtol=0, atol=1e-14)
