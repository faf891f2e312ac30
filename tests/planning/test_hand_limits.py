"""The hand is never faster than its limit, nor is its acceleration greater: judged by differences of its places at 10 kHz."""

import pickle

import numpy as np
import pytest

import ulna
from ulna.errors import InputError, UnknownNameError

HZ = 10_000
SLOW = ulna.HandLimits(speed=0.25)
GENTLE = ulna.HandLimits(speed=0.25, acceleration=1.0)
TIMINGS = [{"acceleration": 5.0}, {"acceleration": 5.0, "jerk": 50.0}, {"limits": "franka"}]


def measured(robot, motion, link=None, since=0.0):
    """The greatest speed, acceleration and angular speed of a link, by differences of its poses."""
    t = np.arange(since, motion.duration + 1 / HZ, 1 / HZ)
    T = robot.forward_kinematics(motion.at(t).q, link=link)
    steps, turns = np.diff(T[:, :3, 3], axis=0), T[1:, :3, :3] @ np.swapaxes(T[:-1, :3, :3], 1, 2)
    off = np.stack([turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]]) / 2
    sizes = [np.linalg.norm(steps, axis=1), np.linalg.norm(np.diff(steps, axis=0), axis=1) * HZ, np.linalg.norm(off, axis=0)]
    return [float(size.max()) * HZ for size in sizes]


def corners(robot, seed, n=4):
    steps = np.random.default_rng(seed).normal(size=(n, robot.n_dof)) * 0.3
    return np.clip(robot.home + np.cumsum(steps, axis=0), np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0))


@pytest.mark.parametrize("options", TIMINGS, ids="-".join)
@pytest.mark.parametrize("hand", [SLOW, GENTLE, ulna.HandLimits(acceleration=1.0), ulna.HandLimits(angular_speed=0.4)], ids=str)
@pytest.mark.parametrize("n", [2, 4], ids=["a line", "corners"])
def test_the_hand_keeps_its_limits_at_all_times(panda, options, hand, n):
    path = corners(panda, 1, n)
    motion = panda.trajectory(path, hand=hand, **options)
    speed, acceleration, angular_speed = measured(panda, motion)
    assert speed <= (hand.speed or np.inf)
    assert acceleration <= (hand.acceleration or np.inf) * (
        1 + 1e-4
    )  # two differences at 10 kHz, beside jumps of the acceleration
    assert angular_speed <= (hand.angular_speed or np.inf)
    assert motion.check()
    assert motion.stops == 0


def test_it_takes_much_less_time_than_a_motion_that_is_slowed_as_a_whole(panda):
    path = panda.home + np.array([[0.0] * 7, [1.5, 0.3, 0, 0.4, 0.5, 1, 0]])
    free = panda.trajectory(path, acceleration=5.0)
    slowed, motion = free.slowed(SLOW.speed / free.hand_peak().value), panda.trajectory(path, acceleration=5.0, hand=SLOW)
    s = free.at(np.linspace(0, free.duration, 4000))
    v = np.linalg.norm(np.einsum("nij,nj->ni", panda.jacobian(s.q)[:, :3], s.qd), axis=1)
    least = np.trapezoid(np.maximum(1, v / SLOW.speed), dx=free.duration / 3999)  # slower only where it is too fast
    assert slowed.duration > 5.0
    assert motion.duration < 1.01 * least < 0.65 * slowed.duration


def test_without_limits_of_the_hand_a_motion_is_the_same_bit_for_bit_as_with_ones_that_it_never_reaches(panda):
    path, wide = corners(panda, 2), ulna.HandLimits(speed=1e3)
    plain, limited = (panda.trajectory(path, acceleration=5.0, hand=hand) for hand in (None, wide))
    assert np.array_equal(plain.times, limited.times)
    assert np.array_equal(plain.q, limited.q)


@pytest.mark.parametrize("name", ["ur5", "baxter", "tiago"])
def test_links_of_any_robot_keep_their_limits_together(name):
    robot = ulna.load(name)
    links = [link for link in robot.link_names if len(robot.tree.moving_columns(link))]
    picked = np.random.default_rng(3).choice(links, 3, replace=False)
    hands = [ulna.HandLimits(0.2, 1.5, link=str(link)) for link in picked]
    motion = robot.trajectory(corners(robot, 5), velocity=2.0, acceleration=6.0, jerk=60.0, hand=hands)
    for hand in motion.hand_limits:
        speed, acceleration, _ = measured(robot, motion, hand.link)
        assert speed <= 0.2
        assert acceleration <= 1.5 * (1 + 1e-4)
    assert len(motion.check().hands) == 6


CART = """<robot name="cart"><link name="world"/><link name="base"/><link name="lift"/><link name="arm"/><link name="tip"/>
<joint name="drive" type="planar"><parent link="world"/><child link="base"/><axis xyz="0 0 1"/></joint>
<joint name="lift" type="prismatic"><parent link="base"/><child link="lift"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" velocity="1" effort="1"/></joint>
<joint name="turn" type="revolute"><parent link="lift"/><child link="arm"/><axis xyz="0 1 0"/><origin xyz="0.2 0 0"/>
<limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
<joint name="wrist" type="revolute"><parent link="arm"/><child link="tip"/><axis xyz="0 0 1"/><origin xyz="0.5 0 0.3"/>
<limit lower="-9" upper="9" velocity="9" effort="1"/><mimic joint="turn" multiplier="-2"/></joint></robot>"""


@pytest.mark.parametrize("jerk", [None, 40.0])
def test_a_slide_a_mimic_joint_and_a_planar_base_are_bounded_too(jerk):
    robot, hand = ulna.load(CART), ulna.HandLimits(speed=0.3, acceleration=0.8, angular_speed=0.5)
    path = np.array([[0, 0, 0, 0.1, 0], [1, 0.5, 1, 0.8, 1.5], [0.5, 1, 2, 0.2, -1.0]])
    motion = robot.trajectory(path, velocity=2.0, acceleration=5.0, jerk=jerk, hand=hand)
    for value, limit in zip(measured(robot, motion), (0.3, 0.8 * (1 + 1e-4), 0.5), strict=True):
        assert value <= limit
    assert motion.check()


@pytest.mark.parametrize("options", TIMINGS, ids="-".join)
@pytest.mark.parametrize("hand", [SLOW, GENTLE], ids=str)
def test_a_plan_and_what_replaces_its_motion_keep_them(panda, world, plan, options, hand):
    motion = plan.trajectory(hand=hand, **options)
    assert motion.certified
    assert motion.check()
    done = 0
    for at in np.linspace(0.1, 0.9, 3) * motion.duration:
        other = panda.plan(motion.at(at).q, plan.path[0], world)
        try:
            changed = motion.replace(other, at=at)
        except InputError:
            continue
        done += 1
        speed, acceleration, _ = measured(panda, changed)
        assert speed <= 0.25
        assert acceleration <= (hand.acceleration or np.inf) * (1 + 1e-4)
        assert changed.check()
        assert changed.hand_limits == motion.hand_limits
    assert done >= 2


def test_velocities_at_the_ends_keep_them_or_are_refused(panda):
    path = corners(panda, 4)
    along = (path[1] - path[0]) / np.linalg.norm(path[1] - path[0])
    rate = np.linalg.norm(panda.jacobian(path[0])[:3] @ along)
    for options in TIMINGS:
        motion = panda.trajectory(path, hand=SLOW, start_velocity=0.2 / rate * along, **options)
        assert measured(panda, motion)[0] <= 0.25
        with pytest.raises(InputError, match=r"start_velocity: the speed of panda_ee would be 0\.3 m/s, but less than its limit"):
            panda.trajectory(path, hand=SLOW, start_velocity=0.3 / rate * along, **options)


def test_the_peak_of_a_motion_with_few_and_long_pieces_is_found(panda, tmp_path):
    """Each piece of a motion from a file is between two of its points: at these the hand rests."""
    file, rests = tmp_path / "motion.csv", [panda.home, panda.home + 0.3, panda.home - 0.1]
    rows = "\n".join(",".join(map(repr, [float(t), *q.tolist(), *[0.0] * 7])) for t, q in enumerate(rests))
    names = panda.joint_names
    file.write_text(",".join(["time", *names, *(f"velocity_{name}" for name in names)]) + "\n" + rows + "\n")
    motion = ulna.Trajectory.from_file(file, panda)
    for quantity, greatest in zip(("speed", "acceleration", "angular_speed"), measured(panda, motion), strict=True):
        peak = motion.hand_peak(quantity=quantity)
        assert peak.limit == np.inf
        assert abs(peak.value - greatest) < 0.02 * greatest  # its accelerations jump, where differences are of both sides
        assert peak.value <= peak.bound < 1.001 * peak.value


def test_check_and_hand_peak_say_how_fast_the_hand_is_and_when(panda):
    path = corners(panda, 1)
    motion = panda.trajectory(path, acceleration=5.0)
    speed, acceleration, angular_speed = measured(panda, motion)
    for quantity, value in (("speed", speed), ("acceleration", acceleration), ("angular_speed", angular_speed)):
        peak = motion.hand_peak(quantity=quantity)
        assert peak.value == pytest.approx(value, rel=1e-3)
        assert value <= peak.bound * (1 + 1e-4)
    peak, at = motion.hand_peak(), 1e-4
    before, behind = (panda.forward_kinematics(motion.at(motion.hand_peak().time + sign * at).q)[:3, 3] for sign in (-1, 1))
    assert np.linalg.norm(behind - before) / (2 * at) == pytest.approx(peak.value, rel=1e-3)
    judged = motion.check(hand=SLOW)
    assert not judged
    assert (judged.joint, judged.quantity, judged.limit) == ("panda_ee", "speed", 0.25)
    said = f"the speed of panda_ee peaks at {peak.value:.4g} m/s at {peak.time:.3f} s"
    assert str(judged) == f"beyond a limit: {said}, {100 * peak.value / 0.25:.4g} % of its limit of 0.25 m/s"
    assert str(peak) == said
    wide = motion.check(hand=ulna.HandLimits(speed=2.0))
    assert wide
    assert f"; the speed of panda_ee peaks at {peak.value:.4g} m/s" in str(wide)
    assert motion.slowed(0.999 * 0.25 / peak.value).check(hand=SLOW)
    assert not motion.slowed(1.001 * 0.25 / peak.value).check(hand=SLOW)


def test_a_motion_keeps_its_hands_when_it_is_slowed_pickled_plotted_or_rests(panda):
    motion = panda.trajectory(corners(panda, 1), acceleration=5.0, hand=SLOW)
    for other in (motion.slowed(0.5), pickle.loads(pickle.dumps(motion))):  # noqa: S301 - our own
        assert other.hand_limits == (ulna.HandLimits(speed=0.25, link="panda_ee"),)
        assert other.check()
    assert len(motion.plot().axes) == 4
    still = panda.trajectory([panda.home], acceleration=5.0, hand=SLOW)
    assert still.check().hands[0].value == 0.0


def test_quicker_looks_at_motions_within_them(panda, plan):
    quick = plan.quicker(10, acceleration=5.0, hand=SLOW)
    durations = [each.trajectory(acceleration=5.0, hand=SLOW).duration for each in (plan, quick)]
    assert durations[1] <= durations[0]


@pytest.mark.parametrize(
    ("hand", "kind", "message"),
    [
        (0.25, InputError, "hand: 0.25; an ulna.HandLimits, or several, is expected"),
        ([0.25], InputError, "hand: 0.25; an ulna.HandLimits"),
        (ulna.HandLimits(speed=1, link="panda_link0"), InputError, "no joint moves link 'panda_link0'"),
        ((SLOW, GENTLE), InputError, "link 'panda_ee' is limited twice"),
        (ulna.HandLimits(speed=1, link="hnad"), UnknownNameError, "hnad"),
    ],
    ids=str,
)
def test_what_limits_no_hand_is_refused(panda, hand, kind, message):
    with pytest.raises(kind, match=message):
        panda.trajectory(corners(panda, 1), acceleration=5.0, hand=hand)


@pytest.mark.parametrize(
    "given", [{}, {"speed": 0}, {"speed": -1}, {"acceleration": np.nan}, {"angular_speed": np.inf}, {"speed": "1"}]
)
def test_limits_that_are_none_are_refused(given):
    with pytest.raises(InputError):
        ulna.HandLimits(**given)


def test_several_tips_need_a_link():
    baxter = ulna.load("baxter")
    with pytest.raises(InputError, match="has several tips; name one of"):
        baxter.trajectory(corners(baxter, 1), acceleration=5.0, hand=SLOW)
