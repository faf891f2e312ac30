"""Why a target was not reached: the reason is true, and its numbers are those of plain geometry or of a brute force."""

import numpy as np
import pytest

import formulas
import robots
import ulna
from matrix import matrix
from ulna import Robot

CRANK = [(0, 0, 0, 0), (1.0, 0, 0, 0), (0.6, 0, 0, 0)]


def planar(limits=None):
    """Two joints about z, links of 1 m and 0.6 m."""
    return Robot.from_dh(CRANK, joint_types=["revolute", "revolute", "fixed"], limits=limits)


# ---- unreachable


@pytest.mark.parametrize("task", ["position", "pose"])
@pytest.mark.parametrize(("radius", "gap"), [(1.7, 0.1), (1.6 + 3e-5, 3e-5), (50.0, 48.4)])
def test_beyond_the_outer_radius_the_gap_is_reported_to_rounding(task, radius, gap):
    for angle in (0.0, 2.0, -3.0):
        target = ulna.pose((radius * np.cos(angle), radius * np.sin(angle), 0), (0, 0, angle))
        result = planar().inverse_kinematics(target, task=task)
        if task == "position" or gap > 1e-4:
            assert result.status == "unreachable"
            assert result.reach_excess == pytest.approx(gap, abs=1e-12 * radius)
            assert result.position_error >= result.reach_excess - 1e-12
            assert result.position_error == pytest.approx(gap, rel=1e-3)
        assert not result.success


@pytest.mark.parametrize(("radius", "gap"), [(0.3, 0.1), (0.4 - 3e-5, 3e-5), (0.0, 0.4)])
def test_within_the_inner_hole_the_gap_is_reported_to_rounding(radius, gap):
    result = planar().inverse_kinematics(ulna.pose((radius, 0, 0)), task="position")
    assert result.status == "unreachable"
    assert result.reach_excess == pytest.approx(gap, abs=1e-12)
    assert result.position_error >= gap - 1e-12
    assert result.position_error <= gap + 0.01, "the arm folds, and comes as near as it can"


@pytest.mark.parametrize("radius", [1.6, 1.6 + 0.9e-5, 0.4, 0.4 - 0.9e-5, 1.0])
def test_a_hair_out_of_reach_is_within_the_tolerance(radius):
    result = planar().inverse_kinematics(ulna.pose((0, radius, 0)), task="position")
    assert result.status != "unreachable"
    assert result.reach_excess == 0.0


def test_a_batch_reports_the_gap_of_each():
    T = np.array([ulna.pose((x, 0, 0)) for x in (1.0, 2.0, 0.1, 1.5)])
    result = planar().inverse_kinematics(T, task="position")
    assert result.status.tolist() == ["solved", "unreachable", "unreachable", "solved"]
    np.testing.assert_allclose(result.reach_excess, [0, 0.4, 0.3, 0], rtol=0, atol=1e-12)


def random_arm(rng):
    """Three to seven joints, slides among them, skew axes, long offsets before and behind them."""
    kinds = list(rng.choice(["revolute", "revolute", "revolute", "prismatic"], rng.integers(3, 8)))
    rows = np.column_stack([rng.uniform(-1, 1, (len(kinds), 2)), rng.uniform(-np.pi, np.pi, (len(kinds), 2))])
    limits = [(-0.3, 0.7) if kind == "prismatic" else (-2.5, 2.0) for kind in kinds]
    arm = Robot.from_dh(rows, joint_types=kinds, limits=limits, convention=rng.choice(["standard", "modified"]))
    return arm.with_tool(ulna.pose(rng.uniform(-1, 1, 3) * rng.choice([0.1, 5.0]), rng.uniform(-3, 3, 3)))


def test_no_configuration_of_any_arm_breaks_the_certificate(rng):
    """Asked with no budget, so that the certificate is all there is to say."""
    for _ in range(25):
        arm = random_arm(rng)
        targets = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (400, arm.n_dof)))
        for task in ("pose", "position", "pointing"):
            result = arm.inverse_kinematics(targets, task=task, max_iterations=0)
            assert not (result.status == "unreachable").any()
            assert not result.reach_excess.any()


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e4])
@pytest.mark.parametrize("length", matrix([1.0, 1e3, 1e9, 1e16, 1e60, 1e200, 1.7e308], [1.0, 1e16, 1.7e308]))
def test_no_configuration_breaks_it_however_long_a_slide_may_become_or_however_small_the_arm(rng, scale, length):
    """The bound subtracts lengths as long as the slide; its roundings are as large as they are."""
    for _ in range(20):
        kinds = [*rng.permutation(["revolute", "revolute", "revolute", rng.choice(["revolute", "prismatic"])]), "prismatic"]
        slide = rng.choice([-1.0, 0.0]) * length, length
        limits = [slide if kind == "prismatic" else (-2.5, 2.0) for kind in kinds]
        rows = np.column_stack([scale * rng.uniform(-1, 1, (5, 2)), rng.uniform(-np.pi, np.pi, (5, 2))])
        arm = Robot.from_dh(rows, joint_types=kinds, limits=limits).with_tool(
            ulna.pose(scale * rng.normal(size=3), rng.normal(size=3))
        )
        q = rng.uniform(np.maximum(arm.lower, -scale * np.pi), np.minimum(arm.upper, scale * np.pi), (20, 5))
        targets = arm.forward_kinematics(q)
        for task in ("pose", "position", "pointing"):
            result = arm.inverse_kinematics(targets, task=task, max_iterations=0, position_tolerance=1e-9 * scale)
            assert not (result.status == "unreachable").any()


def test_a_target_beyond_a_slide_that_ends_is_proved_for_any_size():
    for scale in (1e-5, 1.0, 1e4):
        rows = np.array([(0, 0, 0, 0), (1.0, 0, 0, 0), (0.5, 0, np.pi / 2, 0)]) * (scale, scale, 1, 1)
        kinds, limits = ["revolute", "revolute", "prismatic"], [(-3, 3), (-3, 3), (0, scale)]
        arm = Robot.from_dh(rows, joint_types=kinds, limits=limits)
        result = arm.inverse_kinematics(ulna.pose((3.0 * scale, 0, 0)), task="position", position_tolerance=1e-9 * scale)
        assert result.status == "unreachable"
        assert result.reach_excess == pytest.approx(0.7928932188134525 * scale, rel=1e-9)
        assert result.reach_excess <= (3.0 - 1.0 - np.hypot(0.5, 1.0)) * scale


def test_no_configuration_of_the_zoo_breaks_it_either(rng):
    robot = ulna.Robot(robots.every_joint())
    for link in ("fingertip", "hand", "rail", "propeller", "tray"):
        q = rng.uniform(np.maximum(robot.lower, -2), np.minimum(robot.upper, 2), (1000, robot.n_dof))
        result = robot.inverse_kinematics(robot.forward_kinematics(q, link=link), link=link, max_iterations=0)
        assert not (result.status == "unreachable").any()


def test_what_the_tolerances_allow_is_never_called_unreachable(rng):
    """A tool of 20 m: a tenth of a radian moves its end, seen from the wrist, by 2 m."""
    for _ in range(20):
        arm = random_arm(rng).with_tool(ulna.pose((20.0, 0, 0)), name="mast")
        q = rng.uniform(arm.lower, arm.upper, (100, arm.n_dof))
        T = arm.forward_kinematics(q)
        T[:, :3, :3] = [R @ formulas.rotation(rng.normal(size=3), 0.0999) for R in T[:, :3, :3]]
        T[:, :3, 3] += [0.0099 * v / np.linalg.norm(v) for v in rng.normal(size=(100, 3))]
        result = arm.inverse_kinematics(T, max_iterations=0, position_tolerance=0.01, rotation_tolerance=0.1)
        assert not (result.status == "unreachable").any()


def test_the_gap_is_never_larger_than_the_true_one(rng):
    """Of a position: the nearest of many configurations is at least as far away."""
    for _ in range(10):
        arm = random_arm(rng)
        reached = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (4000, arm.n_dof)))[:, :3, 3]
        targets = np.array([ulna.pose(xyz) for xyz in rng.uniform(-15, 15, (30, 3))])
        result = arm.inverse_kinematics(targets, task="position", max_iterations=0)
        nearest = [np.linalg.norm(reached - T[:3, 3], axis=1).min() for T in targets]
        assert (result.reach_excess <= nearest).all()
        assert (result.status == "unreachable").any()


# ---- joint limits


@pytest.mark.parametrize("q", [(1.3, 0.5), (0.0, 2.5), (-1.2, 2.1), (0.9, 2.4)], ids=str)
def test_the_limits_that_prevent_a_solution_are_reported_with_the_excess(q):
    """A pose leaves a planar arm of two joints no choice: the angles that make it are the ones that are missing."""
    arm = planar(limits=[(-1.0, 1.0), (0.1, 2.0)])
    result = arm.inverse_kinematics(arm.forward_kinematics(q))
    assert result.status == "joint limits"
    expected = np.maximum(np.maximum(arm.lower - q, q - arm.upper), 0.0)
    np.testing.assert_allclose(result.limit_excess, expected, rtol=0, atol=1e-5)
    assert ((result.q >= arm.lower) & (result.q <= arm.upper)).all()
    for name, excess in zip(arm.joint_names, expected, strict=True):
        assert (name in str(result)) == (excess > 0)


def test_of_two_elbows_that_pass_a_limit_the_lesser_is_reported():
    arm = planar(limits=[(-1.0, 1.0), (0.5, 2.0)])
    target = arm.forward_kinematics([0.2, 0.3])  # the other elbow is at -0.3
    result = arm.inverse_kinematics(target, task="position")
    assert result.status == "joint limits"
    assert result.limit_excess == pytest.approx([0.0, 0.2], abs=1e-5)


# ---- singular


ASKEW = [(a, d, alpha + 1e-4 * (k == 1), theta) for k, (a, d, alpha, theta) in enumerate(robots.UR5)]


@pytest.mark.parametrize("case", ["stretched", "over the shoulder"])
@pytest.mark.parametrize(("rows", "status"), [(ASKEW, "singular"), (robots.UR5, "unreachable")], ids=["searched", "closed form"])
def test_where_no_joint_can_lessen_what_is_missing_the_arm_is_singular(rng, case, rows, status):
    """A centimeter beyond the stretched arm, which the bound of the reach does not prove; and a wrist too near the first axis.

    Where the arm has a closed form, that there is no solution is proved.
    """
    arm = Robot.from_dh(rows, convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 6)
    target = ulna.pose((0.05, 0, 0.5), (0, np.pi, 0))
    if case == "stretched":
        q = np.array([0, -0.5, 0, -1, -1.5, 0])
        target = arm.forward_kinematics(q)
        out = arm.forward_kinematics(q, link="link3")[:3, 3] - arm.forward_kinematics(q, link="link1")[:3, 3]
        target[:3, 3] += 0.01 * out / np.linalg.norm(out)
    result = arm.inverse_kinematics(target)
    assert result.status == status, str(result)
    assert str(result.reason).startswith("the arm cannot" if status == "singular" else "the closed form has no solution")
    missing = lambda q: np.linalg.norm(formulas.pose_error(arm.description, q, "link6", target))  # noqa: E731
    here, size = missing(result.q), 1e-4
    nearer = [here - missing(result.q + size * v / np.linalg.norm(v)) for v in rng.normal(size=(200, 6))]
    assert max(nearer) < 1e-2 * size, "a motion leads nearer to first order"
    J = formulas.jacobian(arm.description, result.q, "link6")
    values = np.linalg.svd(J, compute_uv=False)
    assert values[-1] < 0.05 * values[0]


# ---- budgets


@pytest.mark.parametrize(
    "options", [{"max_iterations": 0}, {"max_iterations": 5}, {"time_limit": 0}, {"time_limit": 0.0}], ids=str
)
def test_a_budget_that_runs_out_is_not_called_impossible(panda, options):
    many = panda.forward_kinematics(np.random.default_rng(2).uniform(panda.lower, panda.upper, (100, 7)))
    T = many[panda.inverse_kinematics(many).starts.argmax()]  # not solved from home
    result = panda.inverse_kinematics(T, **options)
    assert result.status == "budget spent"
    assert result.position_error == pytest.approx(np.linalg.norm((T - panda.forward_kinematics(result.q))[:3, 3]), abs=1e-12)
    assert "budget" in str(result)
    assert panda.inverse_kinematics(T).success


def test_without_a_step_a_target_at_the_present_pose_is_solved(panda):
    result = panda.inverse_kinematics(panda.forward_kinematics(panda.home), max_iterations=0, time_limit=0)
    assert (result.status, result.iterations, result.starts) == ("solved", 0, 1)
