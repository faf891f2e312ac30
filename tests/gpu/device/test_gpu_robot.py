"""The methods of ``robot.on_gpu()`` against those of the robot on the CPU: on a GPU, or with simulated threads.

``make test-gpu`` runs them where there is a GPU, on many problems. ``make test-cuda`` runs them in numba-cuda's simulator, as
plain Python: few problems, but each thread and each index is the same.
"""

import os
import pickle

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import robots
import ulna
from ulna.gpu import device, device_array, search
from ulna.ik.inverse_kinematics import InverseKinematics

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
N = 7 if SIMULATED else 20_000
HARD = 3 if SIMULATED else 1000
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


@pytest.fixture(autouse=True)
def _few_starts(monkeypatch):
    """As many starts as there are takes the simulator minutes where there is no solution."""
    if SIMULATED:
        monkeypatch.setattr(search, "STEPS", 900)


@pytest.fixture
def q(panda):
    return np.random.default_rng(3).uniform(panda.lower, panda.upper, (N, panda.n_dof))


def cell():
    world = ulna.World()
    rng = np.random.default_rng(4)
    for k in range(30):  # enough for the CPU to make a BVH of them
        world.add(f"box {k}", ulna.Box(rng.uniform(0.02, 0.2, 3)), ulna.pose(rng.uniform(-0.8, 0.8, 3), rng.uniform(-3, 3, 3)))
    return world


def round_cell():
    world = cell()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    world.add("post", ulna.Cylinder(0.05, 1.0), ulna.pose((-0.4, 0.1, 0.5), (0.2, 0, 0)))
    world.add("stone", ulna.ConvexMesh(np.random.default_rng(5).normal(scale=0.1, size=(12, 3))), ulna.pose((0.3, -0.4, 0.4)))
    return world


def same_verdicts(robot, q, world, hits):
    """Outside a hair's breadth of contact."""
    far = np.abs(robot.signed_distance(q, world)) > 1e-9
    return (hits == robot.in_collision(q, world))[far].all()


def test_poses_are_those_of_the_cpu(panda, on_gpu, q):
    np.testing.assert_allclose(on_gpu.forward_kinematics(q), panda.forward_kinematics(q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        on_gpu.forward_kinematics(q, link="panda_link3"), panda.forward_kinematics(q, link="panda_link3"), atol=1e-12
    )
    np.testing.assert_allclose(on_gpu.link_poses(q), panda.link_poses(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", ["base", "link", "spatial"])
def test_jacobians_are_those_of_the_cpu(panda, on_gpu, q, frame):
    expected = panda.jacobian(q, expressed_in=frame)
    np.testing.assert_allclose(on_gpu.jacobian(q, expressed_in=frame), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("world", [None, cell(), round_cell()], ids=["itself", "boxes", "any shapes"])
def test_collisions_are_those_of_the_cpu(panda, on_gpu, q, world):
    assert same_verdicts(panda, q, world, on_gpu.in_collision(q, world))
    distances, expected = on_gpu.signed_distance(q, world), panda.signed_distance(q, world)
    np.testing.assert_allclose(distances, expected, rtol=0, atol=1e-9)
    assert (np.abs(distances - expected) <= 1e-12).mean() > 0.99


def test_the_world_alone_is_checked_where_that_is_asked(panda, on_gpu, q):
    expected = panda.in_collision(q, cell(), self_collision=False)
    assert (on_gpu.in_collision(q, cell(), self_collision=False) == expected).all()


def test_inverse_kinematics_is_verified_by_the_cpu(panda, on_gpu, q):
    T = panda.forward_kinematics(q)
    result = on_gpu.inverse_kinematics(T)
    assert result.success.all()
    assert ((result.q >= panda.lower) & (result.q <= panda.upper)).all()
    off = panda.forward_kinematics(result.q)
    assert np.linalg.norm(off[:, :3, 3] - T[:, :3, 3], axis=1).max() <= 1e-5


def test_targets_without_a_solution_have_the_reasons_of_the_cpu(panda, on_gpu, q):
    T = panda.forward_kinematics(q[:HARD])
    T[0, :3, 3] = (5.0, 0.0, 0.0)
    result = on_gpu.inverse_kinematics(T)
    assert result.status[0] == "unreachable"
    assert result.reach_excess[0] > 3.0
    assert result.success[1:].all()
    one = on_gpu.inverse_kinematics(T[0])
    assert (one.success, one.q.shape) == (False, (7,))
    assert "misses the target by" in str(one.reason)


def shelf():
    """Boxes among which about half of the configurations that reach a place collide."""
    world = ulna.World()
    world.add("floor", ulna.Box((2.0, 2.0, 0.1)), ulna.pose((0.0, 0.0, -0.2)))
    world.add("post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((0.1, 0.35, 0.5)))
    world.add("board", ulna.Box((0.5, 0.5, 0.05)), ulna.pose((0.5, -0.4, 0.7)))
    return world


def clear_configurations(robot, world, n):
    q = robot.random(40 * n, seed=8)
    return q[~robot.in_collision(q, world)][:n]


def test_an_axis_of_the_link_points_as_the_targets_axis(panda, on_gpu):
    T = panda.forward_kinematics(panda.random(2, seed=7))
    for targets in (T, cuda.to_device(T)):
        result = on_gpu.inverse_kinematics(targets, task=ulna.Task.pointing((1.0, 0.0, 0.0)))
        assert result.success.all()
        reached = panda.forward_kinematics(result.q if targets is T else result.q.copy_to_host())
        assert np.abs(reached[:, :3, [0, 3]] - T[:, :3, [0, 3]]).max() < 2e-5


def refuse_the_cpu(monkeypatch):
    def refuse(*_):
        raise AssertionError("the CPU is asked")

    monkeypatch.setattr(InverseKinematics, "inverse_kinematics", refuse)


def test_solutions_are_clear_of_a_world_and_the_cpu_is_not_asked(panda, on_gpu, monkeypatch):
    world = shelf()
    T = panda.forward_kinematics(clear_configurations(panda, world, N))
    assert panda.in_collision(on_gpu.inverse_kinematics(T).q, world).any(), "without the world"
    refuse_the_cpu(monkeypatch)
    result = on_gpu.inverse_kinematics(T, world=world)
    assert result.success.all()
    assert set(result.status) == {"solved"}
    assert not panda.in_collision(result.q, world).any()
    assert np.linalg.norm(panda.forward_kinematics(result.q)[:, :3, 3] - T[:, :3, 3], axis=1).max() <= 1e-5


def hard_targets(panda, world):
    """Out of reach, in a block, clear; the world gets that block."""
    T = panda.forward_kinematics(clear_configurations(panda, world, 3))
    T[0, :3, 3] = (5.0, 0.0, 0.0)
    world.add("block", ulna.Box((0.3, 0.3, 0.3)), T[1])  # around the hand
    return T


@pytest.mark.parametrize("on_device", [False, True])
def test_the_reasons_of_the_rest_are_found_when_they_are_asked_for(panda, on_gpu, on_device):
    world = shelf()
    T = hard_targets(panda, world)
    with pytest.MonkeyPatch.context() as patch:
        refuse_the_cpu(patch)
        result = on_gpu.inverse_kinematics(cuda.to_device(T) if on_device else T, world=world)
        assert list(result.success[:2]) == [False, False]
        q = result.q.copy_to_host() if on_device else result.q
        assert ((q >= panda.lower) & (q <= panda.upper)).all()
        assert (result.position_error[1:] < 1e-5).all(), "what collides is a solution otherwise"
    expected = panda.inverse_kinematics(T, world=world)
    assert list(result.status) == list(expected.status)
    assert list(result.status)[:2] == ["unreachable", "in collision"]
    assert result.reach_excess[0] == pytest.approx(expected.reach_excess[0])
    assert any("block" in pair for pair in result.collisions[1])
    one = on_gpu.inverse_kinematics(T[0], world=world)
    assert (one.status, one.reason.sentence) == ("unreachable", panda.inverse_kinematics(T[0]).reason.sentence)


def test_what_only_the_limits_prevent_has_the_excess_that_the_cpu_finds():
    narrow = ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-0.5, 0.5)] * 6)
    T = narrow.forward_kinematics([[0.1] * 6, [1.0, 0.1, 0.2, 0.3, 0.4, 0.1]])
    found, expected = narrow.on_gpu().inverse_kinematics(T), narrow.inverse_kinematics(T)
    assert list(found.status) == list(expected.status) == ["solved", "joint limits"]
    np.testing.assert_allclose(found.limit_excess, expected.limit_excess, atol=1e-6)


def test_a_search_from_few_starts_says_that_its_budget_is_spent(panda, on_gpu):
    T = panda.forward_kinematics(panda.home)
    T[:3, 3] = 0.0, 0.0, 0.1  # in the base
    few = on_gpu.inverse_kinematics(T, max_iterations=40)
    assert few.status == panda.inverse_kinematics(T, max_iterations=40).status == "budget spent"


def test_what_collides_in_every_solution_has_the_reason_of_the_cpu(panda, on_gpu):
    world = shelf()
    T = panda.forward_kinematics(clear_configurations(panda, world, 2))
    world.add("block", ulna.Box((0.3, 0.3, 0.3)), T[0])  # around the hand
    result = on_gpu.inverse_kinematics(T[0], world=world)
    assert result.status == panda.inverse_kinematics(T[0], world=world).status == "in collision"
    assert "block" in str(result.reason)


def test_results_on_the_device_have_what_those_of_the_host_have(panda, on_gpu):
    world = shelf()
    T = panda.forward_kinematics(clear_configurations(panda, world, HARD))
    T[0, :3, 3] = (5.0, 0.0, 0.0)
    for options in ({}, {"world": world}):
        on_host, there = on_gpu.inverse_kinematics(T, **options), on_gpu.inverse_kinematics(cuda.to_device(T), **options)
        np.testing.assert_array_equal(there.q.copy_to_host(), on_host.q)
        np.testing.assert_array_equal(there.info, on_host.info)
        assert list(there.status) == list(on_host.status)
        assert there.status[0] == "unreachable"
        assert str(there) == str(on_host)
        assert (pickle.loads(pickle.dumps(there)).q == on_host.q).all()  # noqa: S301 - our own bytes


def test_objects_that_some_links_may_touch_are_checked_as_on_the_cpu(panda, on_gpu, q):
    world = cell()
    world.add("table", ulna.Box((1.0, 1.0, 0.2)), ulna.pose((0.0, 0.0, -0.05)), touch_links=["panda_link0", "panda_link1"])
    world.add("ball", ulna.Sphere(0.15), ulna.pose((0.5, 0.0, 0.4)), touch_links=["panda_hand"])
    assert not panda.in_collision(q, world).all(), "although the base is always in the table"
    for batch in (q, q[0], q[:0]):
        hits, distances = on_gpu.in_collision(batch, world), on_gpu.signed_distance(batch, world)
        expected = panda.signed_distance(batch, world)
        np.testing.assert_allclose(distances, expected, rtol=0, atol=1e-9)
        assert (hits == panda.in_collision(batch, world))[np.abs(expected) > 1e-9].all()
    there = cuda.to_device(q)
    assert (on_gpu.in_collision(there, world).copy_to_host() == on_gpu.in_collision(q, world)).all()
    np.testing.assert_array_equal(on_gpu.signed_distance(there, world).copy_to_host(), on_gpu.signed_distance(q, world))


@pytest.mark.parametrize("world", [None, cell(), round_cell()], ids=["itself", "boxes", "any shapes"])
def test_edges_are_certified_as_on_the_cpu(panda, on_gpu, world):
    rng = np.random.default_rng(6)
    n = 4 if SIMULATED else 3000
    a = rng.uniform(panda.lower, panda.upper, (n, 7))
    a[0] = panda.home
    b = np.clip(a + rng.normal(scale=0.15, size=(n, 7)), panda.lower, panda.upper)
    found, expected = on_gpu.edge_in_collision(a, b, world), panda.edge_in_collision(a, b, world)
    differ = found.in_collision != expected.in_collision
    assert differ.mean() <= 1e-3, "by what is nearer than the resolution alone"
    t = np.linspace(0.0, 1.0, 101)[:, None, None]
    samples = a + t * found.free_until[:, None] * (b - a)
    touching = panda.in_collision(samples, world)
    touching[-1] &= ~found.in_collision  # what is touched there may be nearer than rounding
    assert not touching[:, found.free_until > 0.0].any()
    assert np.abs(found.free_until - expected.free_until)[~differ].max() < 0.02
    np.testing.assert_allclose(found.q, a + found.free_until[:, None] * (b - a), atol=1e-12)
    there = on_gpu.edge_in_collision(cuda.to_device(a), cuda.to_device(b), world)
    np.testing.assert_array_equal(there.in_collision.copy_to_host(), found.in_collision)
    np.testing.assert_array_equal(there.free_until.copy_to_host(), found.free_until)
    one = on_gpu.edge_in_collision(a[0], b[0], world)
    assert (bool(one), one.free_until) == (found.in_collision[0], found.free_until[0])


def test_edges_that_cannot_be_taken_are_refused_by_name(panda, on_gpu, q):
    bad = q[:2].copy()
    bad[1, 3] = np.nan
    for place in (np.array, cuda.to_device):
        with pytest.raises(ulna.InputError, match=r"q_b\[1, 3\]"):
            on_gpu.edge_in_collision(place(q[:2]), place(bad))
    with pytest.raises(ulna.InputError, match="q_b"):
        on_gpu.edge_in_collision(cuda.to_device(q[:2]), q[:2])
    with pytest.raises(ulna.InputError, match="resolution"):
        on_gpu.edge_in_collision(q[:2], q[:2], resolution=0.0)


def test_what_has_closed_forms_is_measured_without_scratch(panda, on_gpu, q, monkeypatch):
    world = cell()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    world.add("rod", ulna.Capsule(0.05, 0.4), ulna.pose((-0.4, 0.1, 0.5), (0.2, 0, 0)))
    world.add("floor", ulna.HalfSpace(), ulna.pose((0.0, 0.0, -0.3)))
    monkeypatch.setattr(device, "free_memory", lambda _: 0)
    np.testing.assert_allclose(on_gpu.signed_distance(q, world), panda.signed_distance(q, world), rtol=0, atol=1e-9)
    assert same_verdicts(panda, q, world, on_gpu.in_collision(q, world))
    with pytest.raises(ulna.DeviceError, match="too little memory"):
        on_gpu.signed_distance(q, round_cell())


def test_a_call_while_another_card_is_selected_is_refused(panda, q, monkeypatch):
    on_gpu, selected = panda.on_gpu(), device_array.card()
    monkeypatch.setattr("ulna.gpu.queue.card", lambda: selected + 1)
    for call in (on_gpu.forward_kinematics, on_gpu.in_collision, on_gpu.signed_distance, on_gpu.gravity_torque):
        with pytest.raises(ulna.DeviceError, match=rf"card {selected + 1}.*select_device\({selected}\)"):
            call(q)
    monkeypatch.undo()
    np.testing.assert_allclose(on_gpu.forward_kinematics(q[0]), panda.forward_kinematics(q[0]), atol=1e-12)


def test_a_seed_and_a_task_are_taken(panda, on_gpu, q):
    T = panda.forward_kinematics(q[:HARD])
    result = on_gpu.inverse_kinematics(T, q[:HARD])
    np.testing.assert_allclose(result.q, q[:HARD], atol=1e-5)
    free = on_gpu.inverse_kinematics(T, panda.home, task="position")
    assert free.success.all()
    np.testing.assert_allclose(panda.forward_kinematics(free.q)[:, :3, 3], T[:, :3, 3], atol=1e-5)


def test_leading_axes_and_single_configurations_keep_their_shapes(panda, on_gpu, q):
    block = q[:6].reshape(2, 3, 7)
    assert on_gpu.forward_kinematics(block).shape == (2, 3, 4, 4)
    assert on_gpu.jacobian(block).shape == (2, 3, 6, 7)
    assert on_gpu.in_collision(block, cell()).shape == (2, 3)
    assert on_gpu.forward_kinematics(q[0]).shape == (4, 4)
    assert on_gpu.signed_distance(q[0], cell()).shape == ()
    assert on_gpu.forward_kinematics(q[:0]).shape == (0, 4, 4)
    assert on_gpu.inverse_kinematics(np.empty((0, 4, 4))).q.shape == (0, 7)


def test_arrays_of_several_pieces_are_put_together_in_their_order(panda, on_gpu, q, monkeypatch):
    whole = on_gpu.forward_kinematics(q), on_gpu.in_collision(q, cell()), on_gpu.signed_distance(q, round_cell())
    q.setflags(write=False)
    monkeypatch.setattr("ulna.gpu.device.PIECE", -(-len(q) // 3) - 1)  # the last piece is a short one, in a used place
    pieces = on_gpu.forward_kinematics(q), on_gpu.in_collision(q, cell()), on_gpu.signed_distance(q, round_cell())
    for one, other in zip(whole, pieces, strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_cannot_be_taken_is_refused_by_name_as_on_the_cpu(panda, on_gpu, q):
    bad = q.copy()
    bad[2, 3] = np.nan
    for call in (on_gpu.forward_kinematics, on_gpu.jacobian, on_gpu.link_poses, on_gpu.in_collision, on_gpu.signed_distance):
        with pytest.raises(ulna.InputError, match=r"q\[2, 3\]"):
            call(bad)
        with pytest.raises(ulna.InputError, match="shape"):
            call(q[:, :6])
    with pytest.raises(ulna.InputError, match="T"):
        on_gpu.inverse_kinematics(np.zeros((2, 4, 4)))
    with pytest.raises(ulna.UnknownNameError):
        on_gpu.forward_kinematics(q, link="hand of god")
    with pytest.raises(ulna.InputError, match="nothing to check"):
        on_gpu.in_collision(q, self_collision=False)
    with pytest.raises(ulna.InputError, match="World"):
        on_gpu.inverse_kinematics(panda.forward_kinematics(q), world="a table")


def test_arrays_on_the_device_stay_there(panda, on_gpu, q):
    there = cuda.to_device(q)
    T = on_gpu.forward_kinematics(there)
    assert hasattr(T, "copy_to_host")
    np.testing.assert_allclose(T.copy_to_host(), panda.forward_kinematics(q), rtol=0, atol=1e-12)
    found = on_gpu.inverse_kinematics(T)
    assert hasattr(found.q, "copy_to_host")
    np.testing.assert_allclose(panda.forward_kinematics(found.q.copy_to_host()), T.copy_to_host(), atol=1e-4)
    hits = on_gpu.in_collision(found.q, cell())
    assert same_verdicts(panda, found.q.copy_to_host(), cell(), hits.copy_to_host())
    with pytest.raises(ulna.InputError, match="float64"):
        on_gpu.forward_kinematics(cuda.to_device(q.astype(np.float32)))
    with pytest.raises(ulna.InputError, match="C-contiguous"):
        on_gpu.forward_kinematics(cuda.to_device(np.asfortranarray(q)))


def test_results_go_where_the_caller_wants_them(panda, on_gpu, q):
    n, there = len(q), cuda.to_device(q)
    world = cell()
    calls = [
        (on_gpu.forward_kinematics, (n, 4, 4), float), (on_gpu.jacobian, (n, 6, 7), float),
        (on_gpu.link_poses, (n, len(panda.link_names), 4, 4), float),
        (lambda q, out=None: on_gpu.in_collision(q, world, out=out), (n,), bool),
        (lambda q, out=None: on_gpu.signed_distance(q, world, out=out), (n,), float),
    ]  # fmt: skip
    for call, shape, kind in calls:
        expected, on_host, on_device = call(q), np.empty(shape, kind), cuda.device_array(shape, kind)
        assert call(q, out=on_host) is on_host
        assert call(there, out=on_device) is on_device
        np.testing.assert_array_equal(on_host, expected)
        np.testing.assert_array_equal(on_device.copy_to_host(), expected)
    for bad in (np.empty((n, 4, 4), np.float32), np.empty((n, 3, 4)), cuda.device_array((n, 4, 4)), [0.0], np.empty((4, 4, n)).T):
        with pytest.raises(ulna.InputError, match="out"):
            on_gpu.forward_kinematics(q, out=bad)


def test_a_block_of_calls_raises_at_its_end_what_was_out_of_range(panda, q):
    on_gpu, good = panda.on_gpu(), cuda.to_device(q)
    bad = q.copy()
    bad[2, 3] = np.nan
    bad = cuda.to_device(bad)
    done = []

    def block():
        with on_gpu.checked(cuda.stream()):
            on_gpu.forward_kinematics(good)
            on_gpu.jacobian(bad)
            done.append(on_gpu.in_collision(good, cell()))

    with pytest.raises(ulna.InputError, match=r"q\[2, 3\]"):
        block()
    assert len(done) == 1, "the block was not left before its end"
    np.testing.assert_array_equal(on_gpu.jacobian(good).copy_to_host(), on_gpu.jacobian(q))
    with on_gpu.checked():
        for _ in range(70):  # more than there are flags
            T = on_gpu.forward_kinematics(good[:2])
        found = on_gpu.inverse_kinematics(T[:2])
        with pytest.raises(ulna.InputError, match=r"q\[2, 3\]"):
            on_gpu.forward_kinematics(bad.copy_to_host())
    assert found.success.all()
    with pytest.raises(ulna.InputError, match="stream"), on_gpu.checked("fast"):
        pass


def test_a_block_that_an_error_ends_leaves_no_flag_to_later_calls(panda, q):
    on_gpu, good, bad = panda.on_gpu(), cuda.to_device(q), q.copy()
    bad[2, 3] = np.nan
    bad = cuda.to_device(bad)

    def block():
        with on_gpu.checked():
            for rows in (good, good, bad):
                on_gpu.forward_kinematics(rows)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        block()
    np.testing.assert_array_equal(on_gpu.forward_kinematics(good).copy_to_host(), on_gpu.forward_kinematics(q))
    with pytest.raises(ulna.InputError, match=r"q\[2, 3\]"):
        on_gpu.forward_kinematics(bad)


def test_a_link_may_have_any_name(panda, q):
    robot = ulna.load(panda.to_urdf().replace('"panda_link3"', '"frames"'))
    on_gpu = robot.on_gpu()
    on_gpu.link_poses(q)
    np.testing.assert_allclose(
        on_gpu.forward_kinematics(q, link="frames"), robot.forward_kinematics(q, link="frames"), atol=1e-14
    )


class OnlyDlpack:
    """An array on the device that has DLPack alone, as those of JAX."""

    def __init__(self, array):
        self.__dlpack__, self.__dlpack_device__ = array.__dlpack__, array.__dlpack_device__


@pytest.mark.skipif(SIMULATED, reason="the simulator's arrays are on the host; see test_device_arrays.py")
def test_arrays_are_given_and_taken_by_dlpack(panda, on_gpu, q):
    T = on_gpu.forward_kinematics(cuda.to_device(q))
    assert T.__dlpack_device__()[0] == 2
    found = on_gpu.inverse_kinematics(OnlyDlpack(T))
    there = on_gpu.forward_kinematics(OnlyDlpack(found.q))
    np.testing.assert_allclose(there.copy_to_host(), T.copy_to_host(), atol=1e-4)


def test_a_robot_whose_batches_go_to_the_gpu_can_still_be_pickled(panda):
    panda.on_gpu()
    assert pickle.loads(pickle.dumps(panda)).joint_names == panda.joint_names  # noqa: S301 - our own bytes
