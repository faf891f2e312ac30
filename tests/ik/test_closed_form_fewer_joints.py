"""Closed forms of arms with three, four and five joints, and with joints that slide, judged by forward kinematics and searches.

A target is made by a configuration, which has to be among the solutions; what a search from many starts finds has to be too.
"""

import numpy as np
import pytest

import formulas
import robots
import ulna
from closed_form_arms import HALF_TURN, direction
from ulna import Robot
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link
from ulna.ik.closed_form.closed_form import closed_form_of

TURN = 2 * np.pi
X, Y, Z = np.eye(3)
REACH = Limits(-2.0, 2.0)


def arm(kinds, h, c, rng):
    """An arm of joints that turn (R) about an axis h through c, or slide (P) along it; a tool stands askew at its end."""
    n = len(kinds)
    links = tuple(Link(f"l{k}") for k in range(n + 2))
    steps = np.diff(np.vstack([np.zeros(3), c]), axis=0)
    joints = [
        Joint(
            f"j{k + 1}", JointType.REVOLUTE if kind == "R" else JointType.PRISMATIC, f"l{k}", f"l{k + 1}",
            formulas.transform(np.eye(3), steps[k]), np.array(h[k]), HALF_TURN if kind == "R" else REACH,
        )
        for k, kind in enumerate(kinds)
    ]  # fmt: skip
    tool = formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.uniform(-0.2, 0.2, 3))
    return Robot(Description("arm", links, (*joints, Joint("tool", JointType.FIXED, f"l{n}", f"l{n + 1}", tool, Z))))


def points(rng, n, same=()):
    c = rng.uniform(-0.4, 0.4, (n, 3))
    for i, j in same:
        c[j] = c[i]
    return c


def d(rng):
    return direction(rng)


def of_kind(name, rng):
    """An arm by the name of its geometry."""
    a, b, e, f = (d(rng) for _ in range(4))
    geometry = {
        "RRR, 2 and 3 parallel": ("RRR", (a, b, -b), ()),
        "RRR, 1 and 2 parallel": ("RRR", (a, a, b), ()),
        "RRR, 1 and 2 intersecting": ("RRR", (a, b, e), [(0, 1)]),
        "RRR, 2 and 3 intersecting": ("RRR", (a, b, e), [(1, 2)]),
        "PPP": ("PPP", (a, b, e), ()),
        "RRP, 1 and 2 intersecting": ("RRP", (a, b, e), [(0, 1)]),
        "PRR, 2 and 3 parallel": ("PRR", (a, b, b), ()),
        "RPP": ("RPP", (a, b, e), ()),
        "PPR": ("PPR", (a, b, e), ()),
        "RPR, 1 and 2 parallel": ("RPR", (a, a, b), [(0, 2)]),
        "RR, planar": ("RR", (a, -a), ()),
        "RRR, planar": ("RRR", (a, -a, a), ()),
        "RRRP, SCARA": ("RRRP", (Z, Z, Z, -Z), ()),
        "RRPR, SCARA": ("RRPR", (Z, -Z, Z, Z), ()),
        "PRRR, SCARA": ("PRRR", (Z, Z, Z, Z), ()),
        "RPRR, SCARA": ("RPRR", (Z, Z, Z, Z), ()),
        "RRRR, 2 and 3 parallel": ("RRRR", (a, b, b, e), ()),
        "RRRR, 2, 3 and 4 parallel": ("RRRR", (Z, Y, Y, -Y), ()),
        "PPPR": ("PPPR", (X, Y, Z, Z), ()),
        "RRRRR, 2, 3 and 4 parallel": ("RRRRR", (a, b, b, b, e), ()),
        "RRRRR, as so100 is": ("RRRRR", (Z, Y, Y, Y, X), ()),
        "RRRRR, 2 and 3 parallel, 4 and 5 intersecting": ("RRRRR", (a, b, b, e, f), [(3, 4)]),
        "RRRRR, 1 and 2 intersecting, 3, 4 and 5 parallel": ("RRRRR", (a, b, e, e, e), [(0, 1)]),
        "RRRRR, 1, 2 and 3 in a point, 4 and 5 parallel": ("RRRRR", (a, b, e, f, f), [(0, 1), (0, 2)]),
        "RRRRR, 3, 4 and 5 in a point": ("RRRRR", (a, b, e, f, d(rng)), [(2, 3), (2, 4)]),
        "RRRRR, 1 and 2 parallel, 3, 4 and 5 in a point": ("RRRRR", (a, -a, e, f, d(rng)), [(2, 3), (2, 4)]),
        "RRRRR, 1 and 2 intersecting, 3, 4 and 5 in a point": ("RRRRR", (a, b, e, f, d(rng)), [(0, 1), (2, 3), (2, 4)]),
        "RRRRR, as a Puma without its elbow": ("RRRRR", (Z, Y, X, Y, X), [(2, 3), (2, 4)]),
        "RRRRR, 4 and 5 intersecting near 3, parallel to 2": ("RRRRR", (a, b, b, e, f), [(3, 4)]),
        "PRRRR": ("PRRRR", (a, b, b, e, f), [(3, 4)]),
        "PPPRRR": ("PPPRRR", (a, b, e, f, d(rng), d(rng)), [(3, 4), (3, 5)]),
        "RRPRRR, Stanford": ("RRPRRR", (Z, Y, Z, Z, Y, Z), [(0, 1), (3, 4), (3, 5)]),
        "PRRRRR, on a rail": ("PRRRRR", (X, (Z + X) / np.sqrt(2), (Z + X) / np.sqrt(2), X, Y, X), [(3, 4), (3, 5)]),
        "RRRPRR, from its end": ("RRRPRR", (a, b, e, f, d(rng), d(rng)), [(0, 1), (0, 2), (4, 5)]),
    }[name]
    kinds, h, same = geometry
    c = points(rng, len(kinds), same)
    if "near 3" in name:
        c[2] = c[3] + 0.01 * d(rng)
    return arm(kinds, h, c, rng)


THREE = [
    "RRR, 2 and 3 parallel", "RRR, 1 and 2 parallel", "RRR, 1 and 2 intersecting", "RRR, 2 and 3 intersecting", "PPP",
    "RRP, 1 and 2 intersecting", "PRR, 2 and 3 parallel", "RPP", "PPR", "RPR, 1 and 2 parallel",
]  # fmt: skip
ALL = [
    *THREE, "RR, planar", "RRR, planar", "RRRP, SCARA", "RRPR, SCARA", "PRRR, SCARA", "RPRR, SCARA", "RRRR, 2 and 3 parallel",
    "RRRR, 2, 3 and 4 parallel",
    "PPPR", "RRRRR, 2, 3 and 4 parallel", "RRRRR, as so100 is", "RRRRR, 2 and 3 parallel, 4 and 5 intersecting",
    "RRRRR, 1 and 2 intersecting, 3, 4 and 5 parallel", "RRRRR, 1, 2 and 3 in a point, 4 and 5 parallel",
    "RRRRR, 4 and 5 intersecting near 3, parallel to 2",
    "RRRRR, 3, 4 and 5 in a point", "RRRRR, 1 and 2 parallel, 3, 4 and 5 in a point",
    "RRRRR, 1 and 2 intersecting, 3, 4 and 5 in a point", "RRRRR, as a Puma without its elbow", "PRRRR", "PPPRRR",
    "RRPRRR, Stanford", "PRRRRR, on a rail", "RRRPRR, from its end",
]  # fmt: skip


def apart(robot, a, b):
    """The largest difference of two configurations, whole turns of the joints that turn aside."""
    turns = np.array([joint.type == JointType.REVOLUTE for joint in robot.description.joints[: robot.n_dof]])
    return np.where(turns, np.abs((a - b + np.pi) % TURN - np.pi), np.abs(a - b)).max(axis=-1)


def targets_of(robot, rng, n):
    q = rng.uniform(robot.lower, robot.upper, (n, robot.n_dof))
    return q, robot.forward_kinematics(q)


def assert_in(robot, found, q):
    least = apart(robot, np.where(found.real[..., None], found.q, 99.0), q[:, None]).min(axis=1)
    assert least.max() < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_the_configuration_that_made_a_pose_is_among_the_solutions(name):
    for seed in range(3):
        rng = np.random.default_rng([seed, len(name)])
        robot = of_kind(name, rng)
        form = robot.closed_form
        assert form is not None
        assert form.is_exact
        q, T = targets_of(robot, rng, 300)
        found = robot.all_solutions(T)
        assert set(found.proof) <= {"complete", "complete but for coinciding branches"}
        assert (found.proof == "complete").mean() > 0.99
        assert_in(robot, found, q)
        reached = robot.forward_kinematics(found.q[found.real])
        assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 4e-9
        np.testing.assert_array_equal(robot.all_solutions(T[3]).q, found.q[3])


@pytest.mark.parametrize("name", THREE)
def test_a_position_is_reached_by_three_joints_in_all_ways(name):
    for seed in range(3):
        rng = np.random.default_rng([seed, len(name)])
        robot = of_kind(name, rng)
        q, T = targets_of(robot, rng, 300)
        T[:, :3, :3] = formulas.rotation(rng.normal(size=3), 1.0)  # any other
        found = robot.all_solutions(T, task="position")
        assert set(found.proof) <= {"complete", "complete but for coinciding branches"}
        assert (found.proof == "complete").mean() > 0.99
        assert_in(robot, found, q)
        reached = robot.forward_kinematics(found.q[found.real])[:, :3, 3]
        assert np.abs(reached - np.repeat(T[:, :3, 3], found.real.sum(axis=1), axis=0)).max() < 4e-9
        assert found.real.sum(axis=1).max() <= 4


@pytest.mark.parametrize("name", [*THREE, "RRRRR, 2, 3 and 4 parallel"])
def test_a_search_from_many_starts_finds_no_more(name):
    rng = np.random.default_rng(len(name))
    robot = of_kind(name, rng)
    task = "position" if len(name.split(",")[0]) == 3 else "pose"
    _, T = targets_of(robot, rng, 3)
    options = {"task": task, "position_tolerance": 1e-8, "rotation_tolerance": 1e-8}
    for target in T:
        found = robot.all_solutions(target, task=task)
        for start in rng.uniform(robot.lower, robot.upper, (60, robot.n_dof)):
            result = robot.inverse_kinematics(target, start, max_iterations=60, **options)
            if result.success:
                assert apart(robot, found.q[found.real], result.q).min() < 1e-4


@pytest.mark.parametrize("name", ALL)
def test_a_pose_off_the_arm_s_manifold_has_no_solution_and_that_is_proved(name):
    rng = np.random.default_rng(5)
    robot = of_kind(name, rng)
    if robot.n_dof == 6:
        return
    _, T = targets_of(robot, rng, 50)
    T[:, :3, :3] = T[:, :3, :3] @ formulas.rotation([0.3, 0.5, -0.8], 1e-4)
    T[:, :3, 3] += [1e-5, -2e-5, 1e-5]
    found = robot.all_solutions(T)
    assert not found.real.any()
    assert (found.proof == "complete").all()


# ---- pointing


def five(rng, *, through=True):
    """An arm of five joints like so100's: 2, 3 and 4 parallel. The link's z axis crosses axis 5, or passes it."""
    robot = of_kind("RRRRR, as so100 is", rng)
    description = robot.description
    axis = description.joints[4].axis
    z = direction(rng)
    R = np.column_stack([robots.unit(*np.cross(z, X + 0.1)), np.zeros(3), z])
    R[:, 1] = np.cross(z, R[:, 0])
    at = axis * 0.1 + z * 0.3 if through else np.array([0.1, 0.2, 0.3])
    tool = Joint("tool", JointType.FIXED, "l5", "l6", formulas.transform(R, at), Z)
    return Robot(Description("arm", description.links, (*description.joints[:5], tool)))


@pytest.mark.parametrize("through", [True, False])
def test_five_joints_point_a_tool_in_up_to_eight_ways(through):
    """A tool that crosses the last axis, and one that passes it: then the first equation is a quartic."""
    rng = np.random.default_rng(3)
    robot = five(rng, through=through)
    form = closed_form_of(robot.tree, "l6", task=ulna.Task.pointing())
    assert form is not None
    assert form.is_exact
    assert form.family.endswith("5 and 6 intersecting") == through
    q, T = targets_of(robot, rng, 300)
    found = robot.all_solutions(T @ ulna.pose(rpy=(0, 0, 1.0)), task="pointing")
    assert (found.proof == "complete").mean() > 0.99
    assert_in(robot, found, q)
    assert found.real.sum(axis=1).max() >= 4
    reached, wanted = robot.forward_kinematics(found.q[found.real]), np.repeat(T, found.real.sum(axis=1), axis=0)
    assert np.abs((reached - wanted)[:, :3, 2:]).max() < 4e-9


def test_an_axis_of_the_task_is_one_of_the_link():
    rng = np.random.default_rng(3)
    robot = five(rng)
    turned = robot.description.joints[5].origin @ ulna.pose(rpy=(0.4, -0.3, 0.2))
    joints = (*robot.description.joints[:5], Joint("tool", JointType.FIXED, "l5", "l6", turned, Z))
    other = Robot(Description("arm", robot.description.links, joints))
    task = ulna.Task.pointing(ulna.pose(rpy=(0.4, -0.3, 0.2))[:3, :3].T @ Z)
    q, T = targets_of(other, rng, 20)
    found = other.all_solutions(T, task=task)
    assert (found.proof == "complete").all()
    assert_in(other, found, q)
    result = other.inverse_kinematics(T, q, task=task)
    assert result.success.all()
    np.testing.assert_allclose(result.q, q, atol=1e-7)


# ---- what the solver makes of it


@pytest.mark.parametrize(("name", "task"), [(name, "position") for name in THREE] + [("five", "pointing")])
def test_the_solver_returns_the_nearest_branch_and_proves_what_is_out_of_reach(name, task):
    rng = np.random.default_rng(6)
    robot = five(rng) if name == "five" else of_kind(name, rng)
    q, T = targets_of(robot, rng, 20)
    seeds = np.clip(q + rng.uniform(-0.3, 0.3, q.shape), robot.lower, robot.upper)
    result, every = robot.inverse_kinematics(T, seeds, task=task), robot.all_solutions(T, task=task, whole_turns=True)
    assert result.success.all()
    assert (result.iterations == 0).all()
    nearest = np.where(every.valid, np.abs(every.q - seeds[:, None]).max(axis=-1), np.inf).min(axis=1)
    np.testing.assert_allclose(np.abs(result.q - seeds).max(axis=1), nearest, atol=1e-8)
    one = robot.inverse_kinematics(T[2], seeds[2], task=task)
    assert one.q.tobytes() == result.q[2].tobytes()
    far = T[0].copy()
    far[:3, 3] += 50.0
    assert robot.inverse_kinematics(far, task=task).status in {"unreachable", "joint limits"}


def test_a_slide_longer_than_a_turn_is_not_turned():
    """A gantry of 30 m: 2 pi added to a length would be another place."""
    rng = np.random.default_rng(1)
    robot = arm("PPP", np.eye(3), points(rng, 3), rng)
    joints = tuple(
        Joint(joint.name, joint.type, joint.parent, joint.child, joint.origin, joint.axis, Limits(-30.0, 30.0))
        if joint.type == JointType.PRISMATIC
        else joint
        for joint in robot.description.joints
    )
    gantry = Robot(Description("gantry", robot.description.links, joints))
    q = np.array([25.0, -20.0, 11.0])
    T = gantry.forward_kinematics(q)
    np.testing.assert_allclose(gantry.inverse_kinematics(T, task="position").q, q, atol=1e-9)
    np.testing.assert_allclose(gantry.all_solutions(T, task="position").q[0], q, atol=1e-9)


def test_stretched_at_the_border_of_the_reach_there_is_a_solution():
    """The two branches of the elbow are one, and its rounded target may lie beyond the reach by a bit."""
    robot = arm("RRR", (Z, Y, Y), np.array([[0, 0, 0], [0, 0, 0.3], [0.5, 0, 0.3]]), np.random.default_rng(1))
    joints = (*robot.description.joints[:3], Joint("tool", JointType.FIXED, "l3", "l4", ulna.pose((0.4, 0, 0)), Z))
    robot = Robot(Description("arm", robot.description.links, joints))
    q = np.random.default_rng(2).uniform(-3, 3, (100, 3))
    q[:, 2] = 0.0
    T = robot.forward_kinematics(q)
    for task in ("position", "pose"):
        found = robot.all_solutions(T, task=task)
        assert found.real.any(axis=1).all()
        assert np.nanmin(apart(robot, found.q, q[:, None]), axis=1).max() < 1e-5


def test_named_arms_of_five_joints_have_their_forms():
    so100 = ulna.load("so100", tip="gripper")
    rng = np.random.default_rng(0)
    q, T = targets_of(so100, rng, 100)
    found = so100.all_solutions(T)
    assert (found.proof == "complete").all()
    assert np.nanmin(np.abs(found.q - q[:, None]).max(axis=-1), axis=1).max() < 1e-9
    assert "with 1 of the joints added" in str(so100.closed_form)


LENGTHS = 0.3, 0.2, 0.1
PLANAR = [(length, 0, 0, 0) for length in LENGTHS]  # a, d, alpha, theta_offset


@pytest.mark.parametrize(("n", "task"), [(2, "position"), (3, "pose")])
def test_a_planar_arm_has_the_two_solutions_of_the_textbook(n, task):
    # Law of cosines in the triangle of the first two links; three joints turn the hand by what the angles add up to.
    robot = Robot.from_dh(PLANAR[:n], convention="standard", limits=[(-np.pi, np.pi)] * n)
    a, b = LENGTHS[:2]
    T = robot.forward_kinematics(robot.random(300, seed=4))
    found = robot.all_solutions(T, task=task)
    turn = np.arctan2(T[:, 1, 0], T[:, 0, 0])
    x, y = (T[:, k, 3] - (LENGTHS[2] * T[:, k, 0] if n == 3 else 0.0) for k in (0, 1))
    elbow = np.arccos((x**2 + y**2 - a**2 - b**2) / (2 * a * b))
    assert set(found.proof) == {"complete"}
    assert set(found.real.sum(axis=1)) == {2}
    for second in (elbow, -elbow):
        first = np.arctan2(y, x) - np.arctan2(b * np.sin(second), a + b * np.cos(second))
        q = np.stack([first, second, turn - first - second][:n], axis=1)
        difference = np.remainder(found.q - q[:, None] + np.pi, TURN) - np.pi
        assert (np.nanmin(np.abs(difference).max(axis=2), axis=1) < 1e-8).all()


def test_a_planar_arm_with_more_joints_than_a_task_needs_has_no_closed_form():
    robot = Robot.from_dh(PLANAR, convention="standard")
    assert closed_form_of(robot.tree, str(robot.tip), None, ulna.Task.position()) is None
    assert Robot.from_dh([*PLANAR, (0.1, 0, 0, 0)], convention="standard").closed_form is None
    assert Robot.from_dh([(0, 0, 0, 0), *PLANAR[:2]], convention="standard").closed_form is None  # two joints about one axis


def test_a_pose_out_of_the_plane_of_a_planar_arm_has_no_solution():
    robot = Robot.from_dh(PLANAR[:2], convention="standard")
    T = robot.forward_kinematics([0.4, 0.9])
    T[2, 3] += 1e-6
    for task in ("pose", "position"):
        found = robot.all_solutions(T, task=task)
        assert found.proof == "complete"
        assert not found.real.any()
