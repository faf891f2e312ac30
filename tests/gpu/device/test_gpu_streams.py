"""The streams of a call's memory, copies and launches, in numba-cuda's simulator.

Simulated threads run at once, so a wrong stream changes no result there. Therefore these tests record the streams.
"""

import os
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import robots
import ulna
from ulna.gpu import device, device_array, edges, scenes, search
from ulna.kernels.distance.epa import SCRATCH

if os.environ.get("NUMBA_ENABLE_CUDASIM") != "1":
    pytest.skip("it records what the simulator is given", allow_module_level=True)

UR5 = ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)


class Recorder:
    """The streams of memory, copies and launches, and what waits for which stream."""

    def __init__(self, patch):
        self.memory, self.launches, self.ordered, self.unfinished, self.shapes, self.read = [], [], [], [], [], []
        array, empty, to_device = type(cuda.to_device(np.zeros(1))), device.empty, cuda.to_device
        compiled, order, copy, read = device.compiled, device.order, array.copy_to_device, array.copy_to_host

        def noted_empty(shape, dtype, stream):
            self.memory.append(stream)
            self.shapes.append(shape)
            return empty(shape, dtype, stream)

        def noted_copy(there, source, stream=0):
            self.unfinished.append(stream or there.stream)
            return copy(there, source, stream)

        def noted_read(there, target=None, stream=0):
            self.read.append(stream or there.stream)
            return read(there, target, stream)

        def noted_to_device(source):
            self.unfinished.append(0)
            return to_device(source)

        def noted_order(before, after):
            self.ordered.append((before, after))
            order(before, after)

        self.default = SimpleNamespace(synchronize=self.unfinished.clear)
        patch.setattr(device, "empty", noted_empty)
        patch.setattr(array, "copy_to_device", noted_copy)
        patch.setattr(array, "copy_to_host", noted_read)
        patch.setattr(cuda, "to_device", noted_to_device)
        patch.setattr(cuda, "default_stream", lambda: self.default)
        patch.setattr(device, "compiled", lambda driver: _Driver(self, compiled(driver)))
        patch.setattr(device, "order", noted_order)

    def launched(self, grid):
        """Before a launch, every copy is in the order of its stream, or finished."""
        stream = grid[2] if len(grid) > 2 else 0
        before = stream or self.default, *(first for first, then in self.ordered if then is stream)
        assert all(any(copied is each for each in before) for copied in self.unfinished), "a copy may be unfinished"
        self.launches.append(stream)


class _Driver:
    def __init__(self, recorder, driver):
        self.recorder, self.driver = recorder, driver

    def __getitem__(self, grid):
        self.recorder.launched(grid)
        return self.driver[grid]


@pytest.fixture
def recorder(monkeypatch):
    monkeypatch.setattr(search, "STEPS", 900)
    monkeypatch.setattr(scenes, "MAX_ONE_BY_ONE", 10)
    return lambda: Recorder(monkeypatch)


def worlds():
    boxes, cloud, hulls = ulna.World(), ulna.World(), ulna.World()
    boxes.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0.0, 0.3)))
    cloud.add("cloud", ulna.PointCloud(np.random.default_rng(0).uniform(-0.8, 0.8, (20, 3)), 0.02))
    hulls.add("stone", ulna.ConvexMesh(np.random.default_rng(5).normal(scale=0.1, size=(12, 3))))
    return boxes, cloud, hulls


BOXES, CLOUD, HULLS = worlds()
OF_Q = {  # of q and itself once more: an edge without length
    "poses": lambda robot, q: robot.forward_kinematics(q),
    "links": lambda robot, q: robot.link_poses(q),
    "jacobians": lambda robot, q: robot.jacobian(q),
    "boxes": lambda robot, q: robot.in_collision(q, BOXES),
    "cloud": lambda robot, q: robot.in_collision(q, CLOUD),
    "distances": lambda robot, q: robot.signed_distance(q, BOXES),
    "distances of hulls": lambda robot, q: robot.signed_distance(q, HULLS),
    "edges": lambda robot, q: robot.edge_in_collision(q, q, BOXES),
    "gravity": lambda robot, q: robot.gravity_torque(q),
    "inverse dynamics": lambda robot, q: robot.inverse_dynamics(q, q, q),
    "derivatives": lambda robot, q: robot.inverse_dynamics_derivatives(q, q, q),
}
OF_T = {
    "inverse kinematics": lambda robot, T: robot.inverse_kinematics(T, robot.robot.home, world=BOXES),
    "pointing": lambda robot, T: robot.inverse_kinematics(T, task=ulna.Task.pointing((1.0, 0.0, 0.0))),
}


def arrays_of(found):
    """The arrays of a result on the device."""
    parts = found if isinstance(found, tuple) else [found]
    names = "in_collision", "free_until", "q", "valid", "real"
    return [each for part in parts for each in (part, *(getattr(part, name, None) for name in names)) if hasattr(each, "stream")]


def check(recorder, stream, call, given, *, stays=True):
    """All memory and copies of a call are on its stream, or finished before a launch."""
    found = call(given)
    assert recorder.launches
    assert all(memory is stream for memory in recorder.memory), "memory would be freed in the order of another stream"
    if stays:
        assert all(launch is stream for launch in recorder.launches)
        assert arrays_of(found)
        assert all(array.stream is stream for array in arrays_of(found)), "others would wait for another stream"
    return found


@pytest.mark.parametrize("single", [False, True], ids=["float64", "float32"])
@pytest.mark.parametrize("name", OF_Q)
def test_a_call_puts_memory_copies_and_launches_on_its_stream(panda, recorder, name, single):
    there, stream = cuda.to_device(np.array(panda.home[None], np.float32 if single else np.float64)), cuda.stream()
    recorder, on_gpu = recorder(), panda.on_gpu(float32=single)
    with on_gpu.checked(stream):
        check(recorder, stream, lambda q: OF_Q[name](on_gpu, q), there)


@pytest.mark.parametrize("name", OF_Q)
def test_a_call_of_numpy_arrays_follows_the_work_on_its_stream(panda, recorder, name):
    stream, recorder, on_gpu = cuda.stream(), recorder(), panda.on_gpu()
    with on_gpu.checked(stream):
        check(recorder, stream, lambda q: OF_Q[name](on_gpu, q), panda.home[None], stays=False)
    assert all(launch is stream or (stream, launch) in recorder.ordered for launch in recorder.launches)


@pytest.mark.parametrize("on_device", [False, True])
@pytest.mark.parametrize("name", OF_T)
def test_inverse_kinematics_stays_on_its_stream(panda, recorder, name, on_device):
    T = panda.forward_kinematics(panda.home[None])
    given, stream = cuda.to_device(T) if on_device else T, cuda.stream()
    recorder, on_gpu = recorder(), panda.on_gpu()
    with on_gpu.checked(stream):
        check(recorder, stream, lambda T: OF_T[name](on_gpu, T), given, stays=on_device)
    assert all(launch is stream for launch in recorder.launches)


@pytest.mark.parametrize("robot", ["six joints", "seven joints"])
def test_all_solutions_stay_on_their_stream(panda, recorder, robot):
    robot = UR5 if robot == "six joints" else panda
    there, stream = cuda.to_device(robot.forward_kinematics(robot.home[None] + 0.1)), cuda.stream()
    recorder, on_gpu = recorder(), robot.on_gpu()
    with on_gpu.checked(stream):
        found = check(recorder, stream, lambda T: on_gpu.all_solutions(T, n_samples=1), there, stays=robot is UR5)
        assert all(array.stream is stream for array in arrays_of(found))
        recorder.read.clear()
        assert found.copy_to_host().success.all()
        assert len(recorder.read) >= 3
        assert all(read is stream for read in recorder.read)


def test_on_the_default_stream_nothing_waits_for_a_copy(recorder):
    there = cuda.to_device(UR5.forward_kinematics(UR5.home[None] + 0.1))
    recorder, on_gpu = recorder(), UR5.on_gpu()
    with on_gpu.checked():
        on_gpu._queue.marks()
        recorder.default.synchronize = lambda: pytest.fail("it waits")
        on_gpu.all_solutions(there)
        assert recorder.unfinished
        assert all(stream is recorder.default for stream in recorder.unfinished), "a copy without a stream waits"


def test_the_trees_of_clouds_are_followed_by_work_on_another_stream(panda, monkeypatch):
    noted = []
    monkeypatch.setattr(scenes, "MAX_ONE_BY_ONE", 10)
    monkeypatch.setattr(scenes, "order", lambda before, after: noted.append((before, after)))
    on_gpu, there, streams = panda.on_gpu(), cuda.to_device(panda.home[None]), (cuda.stream(), cuda.stream())
    for stream in streams:
        with on_gpu.checked(stream):
            on_gpu.in_collision(there, CLOUD)
    assert noted == [(0, streams[0]), streams]


def test_scratch_of_distances_comes_from_the_pool(panda, recorder):
    recorder, on_gpu = recorder(), panda.on_gpu()
    on_gpu.signed_distance(panda.home[None], HULLS)
    assert {(1, *shape) for shape in SCRATCH} <= set(recorder.shapes)


def test_an_array_for_results_that_names_a_stream_follows_the_work(panda, recorder):
    recorder, on_gpu, own, stream = recorder(), panda.on_gpu(), cuda.stream(), cuda.stream()
    there, out = cuda.to_device(panda.home[None]), device_array.empty((1, 4, 4), float, own)
    with on_gpu.checked(stream):
        assert on_gpu.forward_kinematics(there, out=out) is out
    assert recorder.ordered[-1] == (stream, own)


def test_memory_of_edges_is_freed_in_the_order_of_their_stream(panda):
    scene, stream = panda.on_gpu()._scenes.of(BOXES, True, np.float64, 0), cuda.stream()
    assert edges.near_for(scene, 1, stream).stream is stream


class Foreign:
    """An array of another library, here one of the simulator."""

    def __init__(self, array):
        self.array = array
        self.__cuda_array_interface__ = {"version": 2}


@pytest.mark.parametrize("shape", [(2, 7), (7,)])
def test_the_callers_own_array_is_returned(panda, monkeypatch, shape):
    own = device_array.as_own
    on_gpu, there = panda.on_gpu(), cuda.to_device(np.resize(panda.home, shape))
    for name in ("robot", "forces"):
        taken = lambda name, each, stream: own(name, each.array if isinstance(each, Foreign) else each, stream)  # noqa: E731
        monkeypatch.setattr(f"ulna.gpu.{name}.as_own", taken)
    for call, tail in (
        (on_gpu.forward_kinematics, (4, 4)), (on_gpu.signed_distance, ()), (on_gpu.gravity_torque, (7,)),
        (lambda q, out: on_gpu.inverse_dynamics(q, q, q, out=out), (7,)),
    ):  # fmt: skip
        out = Foreign(cuda.device_array((*shape[:-1], *tail)))
        assert call(there, out=out) is out
        on_host = np.empty((*shape[:-1], *tail))
        assert call(there.copy_to_host(), out=on_host) is on_host
        np.testing.assert_array_equal(out.array.copy_to_host(), on_host)


def unreachable(panda, n=2):
    """Targets, of which the first one is out of reach, and a world whose block is around the hand at the last one."""
    T = panda.forward_kinematics(np.tile(panda.home, (n, 1)))
    T[0, :3, 3] = 5.0, 0.0, 0.0
    world = ulna.World()
    world.add("block", ulna.Box((0.3, 0.3, 0.3)), T[-1])
    return T, world


@pytest.mark.parametrize("on_device", [False, True])
def test_reasons_are_those_of_the_call_whatever_the_caller_changes_later(panda, monkeypatch, on_device):
    monkeypatch.setattr(search, "STEPS", 900)
    T, world = unreachable(panda)
    expected = panda.inverse_kinematics(T, world=world.copy())
    given, q_seed = cuda.to_device(T) if on_device else T, panda.home.copy()
    result = panda.on_gpu().inverse_kinematics(given, q_seed, world=world)
    changed = np.tile(np.eye(4), (2, 1, 1))
    given.copy_to_device(changed) if on_device else np.copyto(given, changed)
    q_seed[:] = 0.0
    world.remove("block")
    world.add("other", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((2.0, 2.0, 2.0)))
    assert list(result.status) == list(expected.status) == ["unreachable", "in collision"]
    assert result.reach_excess[0] == pytest.approx(expected.reach_excess[0])
    assert any("block" in pair for pair in result.collisions[1])


@pytest.mark.parametrize("solved", [False, True])
def test_targets_on_the_device_are_copied_only_if_some_are_unsolved(panda, monkeypatch, solved):
    monkeypatch.setattr(search, "STEPS", 900)
    T = unreachable(panda)[0][solved:]
    found = panda.on_gpu().inverse_kinematics(cuda.to_device(T))
    kept = found.__dict__["_unsolved"].request.T
    assert found.success.all() == solved
    assert len(kept) == (0 if solved else len(T))
