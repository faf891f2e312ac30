"""Robots on long or unlimited slides reach what lies far away, from wherever they stand."""

import numpy as np
import pytest

import formulas
import ulna

pytestmark = pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # they reach kilometers
JOINT = "<joint name='{0}' type='{1}'><parent link='{2}'/><child link='{3}'/><origin xyz='{4}'/><axis xyz='{5}'/>{6}</joint>"
ARM = [("a", "0.2 0 0.3", "0 1 0"), ("c", "0 0 0.3", "0 1 0"), ("d", "0 0 0.3", "1 0 0")]


def on_a_base(*base):
    """An arm of three joints on joints given by name, type, axis and limits."""
    limit = "<limit lower='{0}' upper='{1}' velocity='1' effort='1'/>"
    joints, parent = [], "world"
    for name, kind, axis, bounds in base:
        joints.append(JOINT.format(name, kind, parent, f"on {name}", "0 0 0", axis, limit.format(*bounds) if bounds else ""))
        parent = f"on {name}"
    for name, xyz, axis in ARM:
        joints.append(JOINT.format(name, "revolute", parent, f"on {name}", xyz, axis, limit.format(-2, 2)))
        parent = f"on {name}"
    links = "".join(f"<link name='{name}'/>" for name in ["world", *(f"on {name}" for name, *_ in [*base, *ARM])])
    return ulna.load(f"<robot name='mobile'>{links}{''.join(joints)}</robot>")


def mobile(limit):
    ends = (-limit, limit) if limit else (-1e16, 1e16)
    return on_a_base(("x", "prismatic", "1 0 0", ends), ("y", "prismatic", "0 1 0", ends), ("yaw", "continuous", "0 0 1", None))


def assert_all_solved(robot, result, T):
    assert (result.status == "solved").all(), str(result)
    for q, target in zip(result.q, T, strict=True):
        error = formulas.pose_error(robot.description, q, robot.tip, target)
        assert np.linalg.norm(error[:3]) <= 1e-5
        assert np.linalg.norm(error[3:]) <= 1e-4
    assert ((robot.lower <= result.q) & (result.q <= robot.upper)).all()


@pytest.mark.parametrize(("limit", "far"), [(None, 10), (None, 100), (None, 1e4), (30, 30), (1000, 30), (1000, 1000)])
def test_a_mobile_base_drives_to_every_target(rng, limit, far):
    robot = mobile(limit)
    q = np.column_stack([rng.uniform(-far, far, (20, 2)), rng.uniform(-3, 3, 20), rng.uniform(-2, 2, (20, 3))])
    T = robot.forward_kinematics(q)
    assert_all_solved(robot, robot.inverse_kinematics(T), T)
    assert robot.inverse_kinematics(T, task="position").success.all()
    near = np.clip(q + rng.normal(size=q.shape) * (40, 40, 0.5, 0.5, 0.5, 0.5), robot.lower, robot.upper)
    assert_all_solved(robot, robot.inverse_kinematics(T, near), T)
    assert robot.inverse_kinematics(T[0]).success


@pytest.mark.parametrize("far", [1.0, 100.0, 1e4])
@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_an_arm_on_a_joint_of_several_positions_does_too(rng, kind, far):
    robot = on_a_base(("base", kind, "0 0 1", None))
    q = rng.uniform(-2, 2, (20, robot.n_dof))
    q[:, : 3 if kind == "floating" else 2] *= far / 2
    T = robot.forward_kinematics(q)
    assert_all_solved(robot, robot.inverse_kinematics(T), T)


def test_a_gantry_reaches_all_of_its_room(rng):
    ends = [("x", "1 0 0", (-50, 50)), ("y", "0 1 0", (0, 1e3)), ("z", "0 0 1", (-2, 0))]
    robot = on_a_base(*((name, "prismatic", axis, bounds) for name, axis, bounds in ends))
    q = rng.uniform(robot.lower, robot.upper, (30, 6))
    T = robot.forward_kinematics(q)
    assert_all_solved(robot, robot.inverse_kinematics(T), T)
