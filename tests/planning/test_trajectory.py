"""Trajectories: within every limit at any time, as fast as a linear program says, and free where they are rounded."""

import csv
import io
import pickle
import sys
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image
from scipy.optimize import linprog

import ulna
from ulna.errors import FileError, InputError, MissingExtraError
from ulna.planning.blend import CHORDS, Certificate, edges_of, find_free_cuts, round_corners
from ulna.planning.entries import time_parameterization
from ulna.planning.jerk_limited import bounds_of_acceleration, timed_path
from ulna.planning.timing import Limits, grid_of, time_optimal
from ulna.planning.trajectory import Trajectory

NAMES = tuple("abcdefg")


def random_path(rng, n=5):
    path = np.cumsum(rng.normal(size=(n, 7)), axis=0)
    return path, np.linalg.norm(np.diff(path, axis=0), axis=1)


def random_pieces(rng, n=5, blend=0.2):
    edges = edges_of(*random_path(rng, n))
    return round_corners(edges, find_free_cuts(edges, blend, of_paths(anything)))


def anything(*_):
    return True


def of_paths(is_free):
    """What certifies paths, by a function of one."""

    def n_free(paths, spreads):
        for k, one in enumerate(zip(paths, spreads, strict=True)):
            if not is_free(*one):
                return k
        return len(paths)

    return Certificate(n_free)


def timed(path, lengths, blend, *limits, is_free=anything):
    timed = timed_path(path, lengths, blend, Limits(*limits), of_paths(is_free))
    return Trajectory(True, NAMES[: path.shape[1]], timed)


@pytest.mark.parametrize("blend", [0.0, 0.03, 0.2, 5.0])
def test_no_limit_is_passed_at_any_time(rng, blend):
    for _ in range(5):
        velocity, acceleration = rng.uniform(0.5, 3, 7), rng.uniform(1, 20, 7)
        path = timed(*random_path(rng), blend, velocity, acceleration)
        moment = path.at(np.linspace(0, path.duration, 50_001))
        assert (np.abs(moment.qd) <= velocity * (1 + 1e-12)).all()
        assert (np.abs(moment.qdd) <= acceleration * (1 + 1e-12)).all()


def test_velocity_is_the_derivative_of_position_and_acceleration_that_of_velocity(rng):
    path = timed(*random_path(rng), 0.2, np.full(7, 2.0), np.full(7, 5.0))
    t, h = np.linspace(0.01, path.duration - 0.01, 2000), 1e-6
    t = t[np.abs(t[:, None] - path.times).min(axis=1) > 2 * h]  # the acceleration jumps at grid points
    before, at, behind = path.at(t - h), path.at(t), path.at(t + h)
    assert np.allclose((behind.q - before.q) / (2 * h), at.qd, atol=1e-7)
    assert np.allclose((behind.qd - before.qd) / (2 * h), at.qdd, atol=1e-6)


def test_it_begins_and_ends_at_rest_and_every_grid_point_is_where_it_is_said(plan):
    path = plan.trajectory(acceleration=5.0)
    assert np.array_equal(path.q[0], plan.path[0])
    assert np.allclose(path.q[-1], plan.path[-1], atol=1e-12)
    assert np.abs(path.qd[[0, -1]]).max() < 1e-9
    moment = path.at(path.times)
    assert np.allclose(moment.q, path.q, atol=1e-12)
    assert np.array_equal(path.at([-1.0, path.duration + 1]).q, path.at([0.0, path.duration]).q)


def slow_twin(grid, velocity, acceleration):
    """The greatest (ds/dt)^2 at all grid points at once, by a linear program: the set of allowed ones has a greatest element."""
    n = len(grid.steps)
    ends = grid.slopes + grid.steps[:, None] * grid.bends
    rows, most = [], []
    for i in range(n):
        for slope, of_x in ((grid.slopes[i], i), (ends[i], i + 1)):
            for j in range(len(velocity)):
                row = np.zeros(n + 1)  # qdd = slope u + bend x, with u = (x_{i+1} - x_i) / 2 ds
                row[i + 1] += slope[j] / (2 * grid.steps[i])
                row[i] -= slope[j] / (2 * grid.steps[i])
                row[of_x] += grid.bends[i, j]
                rows += [row, -row]
                most += [acceleration[j]] * 2
    bounds = []
    for i in range(n + 1):
        near = np.vstack([np.abs(each[max(i - 1, 0) : i + 1]) for each in (grid.slopes, ends)])
        x = (velocity / np.maximum(near, 1e-12)).min() ** 2
        bounds.append((0.0, 0.0 if i in grid.borders else x))
    solved = linprog(-np.ones(n + 1), A_ub=np.array(rows), b_ub=most, bounds=bounds, method="highs")
    assert solved.success
    return solved.x


@pytest.mark.parametrize("blend", [0.0, 0.3])
def test_it_is_as_fast_as_a_linear_program(rng, blend):
    for _ in range(4):
        velocity, acceleration = rng.uniform(0.5, 3, 7), rng.uniform(1, 20, 7)
        grid = grid_of(random_pieces(rng, n=4, blend=blend))
        x = time_optimal(grid, velocity, acceleration).profile.speeds ** 2
        assert np.allclose(x, slow_twin(grid, velocity, acceleration)[:-1], rtol=1e-6, atol=1e-7)


def test_a_single_line_takes_the_time_of_a_trapezoid():
    length, velocity, acceleration = 3.0, 1.0, 2.0
    line = np.array([[0.0, 0.0], [0.6 * length, -0.8 * length]])
    path = timed(line, np.array([length]), 0.0, np.full(2, velocity), np.full(2, acceleration))
    v, a = velocity / 0.8, acceleration / 0.8
    assert path.duration == pytest.approx(length / v + v / a, rel=2e-3)
    assert path.duration >= length / v + v / a - 1e-9


@pytest.mark.parametrize("blend", [0.0, 0.05, 0.5])
def test_with_a_limit_of_jerk_no_limit_is_passed_at_any_time(rng, blend):
    for _ in range(10):
        velocity, acceleration, jerk = rng.uniform(0.2, 3, 7), rng.uniform(1, 20, 7), 10 ** rng.uniform(1, 4, 7)
        points, lengths = random_path(rng)
        path = timed(points, lengths, blend, velocity, acceleration, jerk)
        t = np.linspace(0, path.duration, 20_001)
        moment = path.at(t)
        for (values, rates), most in zip(pairwise(moment), (velocity, acceleration, jerk), strict=True):
            assert (np.abs(rates) <= most * (1 + 1e-9)).all()
            assert (np.abs(np.diff(values, axis=0)) <= most * np.diff(t)[:, None] * (1 + 1e-6) + 1e-12).all()
        assert np.allclose(np.diff(moment.qd, axis=0) / np.diff(t)[:, None], (moment.qdd[1:] + moment.qdd[:-1]) / 2, atol=1e-1)
        assert np.allclose(np.diff(moment.q, axis=0) / np.diff(t)[:, None], (moment.qd[1:] + moment.qd[:-1]) / 2, atol=1e-4)
        assert np.allclose(path.q[[0, -1]], points[[0, -1]], atol=1e-9)
        assert np.abs(path.qd[[0, -1]]).max() < 1e-9
        assert path.stops == (len(points) - 2 if blend == 0.0 else 0)
        assert path.duration >= timed(points, lengths, blend, velocity, acceleration).duration * 0.98


@pytest.mark.slow
@pytest.mark.parametrize("jerk", [20.0, 200.0, 10_000.0])
def test_a_mean_is_on_the_path_or_within_what_was_certified(rng, jerk):
    for _ in range(4):
        path, lengths = random_path(rng)
        chords = [(a, b, np.zeros(7)) for a, b in pairwise(path)]

        def is_free(points, spreads):
            chords.extend(zip(points[:-1], points[1:], spreads, strict=True))  # noqa: B023 - called within the round
            return True

        motion = timed(path, lengths, 0.3, rng.uniform(0.5, 3, 7), rng.uniform(1, 20, 7), np.full(7, jerk), is_free=is_free)
        q = motion.at(np.linspace(0, motion.duration, 3001)).q
        a, b, spread = (np.array(each) for each in zip(*chords, strict=True))
        for row in q:  # a share of a chord is near enough in each joint between two bounds
            with np.errstate(divide="ignore", invalid="ignore"):
                ends = (row - a - spread - 1e-9) / (b - a), (row - a + spread + 1e-9) / (b - a)
            lower, upper = np.fmax(np.minimum(*ends).max(axis=1), 0), np.fmin(np.maximum(*ends).min(axis=1), 1)
            assert (lower <= upper).any()


def test_a_limit_of_jerk_that_hardly_matters_takes_hardly_more_time(rng):
    velocity, acceleration = np.full(7, 2.0), np.full(7, 10.0)
    points, lengths = random_path(rng)
    without, within = (timed(points, lengths, 0.2, velocity, acceleration, jerk) for jerk in (None, np.full(7, 5000.0)))
    assert without.duration < within.duration < without.duration + 2 * 10 / 5000 + 1e-3
    t = np.linspace(0, without.duration, 1001)
    window = within.duration - without.duration
    assert np.allclose(within.at(t + window / 2).q, without.at(t).q, atol=10 * window**2 / 24 + 1e-3)


def test_the_window_is_the_least_that_keeps_the_limits_of_jerk(rng):
    for _ in range(10):
        jerk = 10 ** rng.uniform(1, 3, 7)
        motion = time_optimal(grid_of(random_pieces(rng)), np.full(7, 2.0), np.full(7, 5.0))
        lows, highs = bounds_of_acceleration(motion)
        least = np.array([1e-4])
        time_parameterization.least_window(motion.times, lows, highs, jerk, motion.grid.borders, least)
        window = float(least[0])
        t = np.linspace(-window, motion.times[-1], 20_001)

        def acceleration(t, motion=motion):
            rests = (t < 0) | (t > motion.times[-1])
            return np.where(rests[:, None], 0.0, motion.at(np.clip(t, 0, motion.times[-1])).qdd)

        change = np.abs(acceleration(t + window) - acceleration(t)).max(axis=0)
        assert (change <= jerk * window * (1 + 1e-9)).all()
        for shorter in (0.5 * window, 0.9 * window):  # within it the acceleration changes by more than it may
            last = np.searchsorted(motion.times, motion.times[1:] + shorter)
            most = [
                max(np.ptp(np.vstack([lows[i:k], highs[i:k]]), axis=0) / jerk) for i, k in enumerate(np.minimum(last, len(lows)))
            ]
            ends = [*(np.abs(lows[[0, -1]]) / jerk).ravel(), *(np.abs(highs[[0, -1]]) / jerk).ravel()]
            assert max(*most, *ends) > shorter or window == 1e-4


def test_a_corner_about_which_the_mean_is_not_free_is_cut_less_and_then_a_stop(rng):
    points, lengths = random_path(rng, 4)
    limits = np.full(7, 2.0), np.full(7, 5.0), np.full(7, 20.0)
    assert timed(points, lengths, 0.3, *limits).stops == 0

    def free_but_for_the_mean_about_the_first_corner(edges, _spreads):
        return len(edges) == CHORDS + 1 or np.linalg.norm(edges - points[1], axis=1).min() > 0.2

    stopping = timed(points, lengths, 0.3, *limits, is_free=free_but_for_the_mean_about_the_first_corner)
    assert stopping.stops == 1
    assert np.linalg.norm(stopping.at(stopping.rests[1]).q - points[1]) < 1e-9
    assert timed(points, lengths, 0.3, *limits, is_free=lambda *_: False).stops == 2


def test_a_plan_within_limits_of_jerk_flows_through_its_corners_and_touches_nothing(panda, plan):
    for acceleration, jerk in ((15.0, 5000.0), (15.0, 500.0), (5.0, 50.0)):
        path = plan.trajectory(acceleration=acceleration, jerk=jerk)
        assert path.certified
        assert path.stops < len(plan.path) - 2
        assert path.is_free(plan._motion.world)
        assert not panda.in_collision(path.at(np.linspace(0, path.duration, 20_001)).q, plan._motion.world).any()


def test_stops_take_longer_than_rounded_corners(plan):
    stopping, flowing = (plan.trajectory(acceleration=5.0, blend=blend) for blend in (0.0, 0.2))
    assert stopping.stops == len(plan.path) - 2
    assert flowing.stops < stopping.stops
    assert flowing.duration < stopping.duration
    assert f"{stopping.stops} stop" in str(stopping)


@pytest.mark.parametrize("blend", [0.05, 0.5, 10.0])
def test_a_rounded_corner_touches_nothing(panda, world, plan, blend):
    path = plan.trajectory(acceleration=5.0, blend=blend)
    assert path.certified
    q = path.at(np.linspace(0, path.duration, 20_001)).q
    assert not panda.in_collision(q, world).any()


def test_a_corner_that_cannot_be_rounded_is_a_stop(panda):
    path = np.stack([panda.home, panda.home + 0.2, panda.home + np.array([0.2, 0.4, 0.2, 0.2, 0.2, 0.2, 0.2])])
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    asked = []

    def never(points, spreads):
        asked.append((points.copy(), spreads.copy()))
        return False

    edges = edges_of(path, lengths)
    assert not find_free_cuts(edges, 0.1, of_paths(never)).any()
    assert round_corners(edges, np.zeros(3)).borders.tolist() == [0, 1, 2]
    assert len(asked) == 4  # halved three times
    for points, spreads in asked:  # the parabola lies within the spread of its chords
        t = np.linspace(0, 1, 101)[:, None]
        control = points[0], path[1], points[-1]
        curve = (1 - t) ** 2 * control[0] + 2 * t * (1 - t) * control[1] + t**2 * control[2]
        chords = np.concatenate(
            [points[k] + (t[k * 25 : k * 25 + 26] - k / 4) * 4 * (points[k + 1] - points[k]) for k in range(4)]
        )
        parts = np.concatenate([curve[k * 25 : k * 25 + 26] for k in range(4)])
        assert (np.abs(chords - parts) <= np.repeat(spreads, 26, axis=0)).all()


def test_corners_that_are_certified_together_are_cut_as_each_alone(rng):
    """More corners than one call takes, of which every third is free only where its rounding is short."""
    path, lengths = random_path(rng, 200)
    edges, asked = edges_of(path, lengths), []

    def short_is_free(points, _spreads):
        k = int(np.argmin(np.linalg.norm(path - points[CHORDS // 2], axis=1)))
        return k % 3 or np.linalg.norm(points[0] - path[k]) < 0.15 / (1 + k % 7)

    def n_free(paths, spreads):
        asked.append(len(paths))
        return of_paths(short_is_free).n_free(paths, spreads)

    cuts = find_free_cuts(edges, 0.2, Certificate(n_free))
    for k in range(1, len(path) - 1):
        alone = edges_of(path[k - 1 : k + 2], lengths[k - 1 : k + 1])
        assert find_free_cuts(alone, 0.2, of_paths(short_is_free))[1] == cuts[k]
    assert (cuts[1:-1] == 0.0).any()
    assert 1 < max(asked) < len(path) - 2


def test_paths_are_free_together_where_each_is_and_not_between_them(panda, plan):
    motion = plan._motion
    rng, touching = np.random.default_rng(5), np.array([0.0, 0.5, 0, -1.5, 0, 2, 0.8])  # at the post
    at = plan.at(np.linspace(0, 1, 40))
    paths = np.stack([at[rng.integers(38) + np.arange(3)] for _ in range(12)])  # from each to the next is through the post
    spreads = np.full((12, 2, 7), 1e-6)
    alone = [motion.is_free(*one) for one in zip(paths, spreads, strict=True)]
    assert all(alone)
    assert motion.n_free(paths, spreads) == 12
    paths[7, 1] = touching
    assert panda.in_collision(touching, motion.world)
    assert motion.n_free(paths, spreads) == 7
    assert motion.n_free(paths[:7], spreads[:7]) == 7


def test_a_table_has_a_row_for_each_moment(plan, tmp_path):
    path = plan.trajectory(acceleration=5.0)
    path.to_csv(tmp_path / "all.csv")
    path.to_csv(tmp_path / "even.csv", period=0.05)
    with (tmp_path / "all.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0][:2] == ["time", "panda_joint1"]
    assert np.array_equal(np.array(rows[1:], dtype=float)[:, :8], np.column_stack([path.times, path.q]))
    even = np.loadtxt(tmp_path / "even.csv", delimiter=",", skiprows=1)
    assert np.allclose(np.diff(even[:-1, 0]), 0.05)
    assert even[-1, 0] == path.duration
    with pytest.raises(FileError):
        path.to_csv(tmp_path / "none" / "x.csv")
    with pytest.raises(InputError, match="period"):
        path.to_csv(tmp_path / "x.csv", period=0)
    with pytest.raises(InputError, match="period"):
        path.to_csv(tmp_path / "x.csv", period=5e-324)


def test_a_figure_shows_positions_velocities_and_accelerations(plan):
    for options, n_axes in (({}, 3), ({"jerk": 100.0}, 4)):
        figure = plan.trajectory(acceleration=5.0, **options).plot()
        assert len(figure.axes) == n_axes
        for axes, limit in zip(figure.axes[2:], (5.0, 100.0), strict=False):
            curves, ends = axes.lines[:7], axes.lines[7:]
            assert {end.get_linestyle() for end in ends} == {"--"}
            assert {abs(end.get_ydata()[0]) for end in ends} == {limit}
            assert max(np.abs(curve.get_ydata()).max() for curve in curves) <= limit * (1 + 1e-9)


def test_a_notebook_shows_a_figure_once_and_no_window_opens(plan):
    figure = plan.trajectory(acceleration=5.0).plot()
    width, height = Image.open(io.BytesIO(figure._repr_png_())).size
    assert (width, height) == tuple(round(each * figure.dpi) for each in figure.get_size_inches())
    assert plt.get_fignums() == []  # an inline backend shows those of pyplot a second time
    assert isinstance(figure, Figure)


def test_without_matplotlib_the_extra_plot_is_named(plan, monkeypatch):
    monkeypatch.delitem(sys.modules, "ulna.notebook.figure", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match="a plot needs the plot extra: "):
        plan.trajectory(acceleration=5.0).plot()


def test_a_figure_has_the_limits_of_positions_that_are_near(plan):
    motion = plan.trajectory(acceleration=5.0)
    figure = motion.plot()
    drawn = {end.get_ydata()[0] for end in figure.axes[0].lines[7:]}
    reach = 1.5 * np.abs(motion.at(np.linspace(0, motion.duration, 1000)).q).max()
    assert drawn == {end for end in np.ravel(motion.limits["position"]) if abs(end) <= reach}
    assert drawn


def test_a_motion_says_the_limits_with_which_it_was_made(panda, plan):
    limits = plan.trajectory(acceleration=5.0, velocity=np.arange(1.0, 8.0)).limits
    assert list(limits) == ["position", "velocity", "acceleration"]
    assert np.array_equal(limits["position"], [panda.lower, panda.upper])
    assert np.array_equal(limits["velocity"], [-np.arange(1.0, 8.0), np.arange(1.0, 8.0)])
    assert np.array_equal(plan.trajectory(acceleration=5.0, jerk=100.0).limits["jerk"], [[-100.0] * 7, [100.0] * 7])


def test_a_trajectory_survives_pickling(plan):
    path = plan.trajectory(acceleration=5.0)
    other = pickle.loads(pickle.dumps(path))  # noqa: S301
    assert np.array_equal(other.at(0.3).q, path.at(0.3).q)


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"acceleration": 0.0}, "acceleration"),
        ({"acceleration": np.ones(6)}, "acceleration"),
        ({"acceleration": 1.0, "velocity": -1}, "velocity"),
        ({"acceleration": 1.0, "blend": -0.1}, "blend"),
        ({"acceleration": 1.0, "blend": True}, "blend"),
    ],
)
def test_limits_that_make_no_sense_are_refused_by_name(plan, options, argument):
    with pytest.raises(InputError, match=argument):
        plan.trajectory(**options)


def test_a_plan_without_a_path_has_no_trajectory(panda):
    world = ulna.World()
    world.add("block", ulna.Box((0.2, 0.2, 0.2)), panda.forward_kinematics(panda.home))
    away = panda.home.copy()
    away[0] = 2
    plan = panda.plan(away, panda.home, world)
    with pytest.raises(InputError, match="goal in collision"):
        plan.trajectory(acceleration=1.0)


def test_a_plan_that_does_not_move_takes_no_time(panda):
    path = panda.plan(panda.home, panda.home).trajectory(acceleration=1.0)
    assert path.duration == 0
    assert np.array_equal(path.at(0.0).q, panda.home)


def test_a_joint_whose_velocity_is_given_as_zero_is_named_and_other_limits_serve():
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="0" upper="1" velocity="0" effort="1"/></joint>
      <joint name="turn" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="2" effort="1"/></joint></robot>"""
    block = '<link name="c"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
    plan = ulna.load(text.replace('<link name="c"/>', block)).plan([0, 0], [0.5, 0.5])
    with pytest.raises(InputError, match=r"velocity: the description allows 'lift' a velocity of 0.*give velocity="):
        plan.trajectory(acceleration=1.0)
    assert plan.trajectory(acceleration=1.0, velocity=1.0).duration > 0


def test_the_velocity_of_a_mean_over_a_short_time_keeps_its_digits(panda):
    """Minutes of a motion that is a mean over 1e-4 s: its velocity is the difference of nearly equal positions."""
    points = np.stack([panda.home, panda.home + 0.4, panda.home + 0.4 * (np.arange(7) % 2 == 0)])
    velocity = 1e-4 * np.arange(3.0, 10.0)
    motion = panda.trajectory(points, within=1e-4, velocity=velocity, acceleration=1.0, jerk=1e5)
    assert motion.duration > 600.0
    t = np.linspace(0, motion.duration, 50_001)
    assert np.abs(motion.at(t).qd / velocity).max() <= 1 + 1e-11
    assert motion.check(period=0.01)
