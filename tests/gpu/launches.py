"""Calls every method of ``robot.on_gpu()`` in numba-cuda's simulator, and prints what was called and launched, as JSON.

For each launch: where the driver comes from, its grid, the threads of a block and the stream, and whether it was made in a block
of ``checked`` with a stream of its own. Of each argument its dtype, shape and strides, or its type and value; a named tuple's
parts one by one. For each call: the method, and whether ``out`` was given.
"""

import importlib
import json
import pkgutil
import sys
from contextlib import ExitStack, contextmanager
from functools import _lru_cache_wrapper
from pathlib import Path
from types import FunctionType
from unittest import mock

import numpy as np
from numba import cuda

sys.path.insert(0, str(Path(__file__).parents[1]))  # it is run as a program
import robots
import ulna
import ulna.gpu
from gpu_parts import public_methods
from ulna.engine.records import Record
from ulna.gpu import device, scenes
from ulna.gpu.robot import GpuRobot
from ulna.gpu.single import in_single

MODULES = [importlib.import_module(f"ulna.gpu.{module.name}") for module in pkgutil.iter_modules(ulna.gpu.__path__)]
launches: list[dict] = []
calls: list[list] = []
sources: dict[FunctionType, list] = {}
own_streams: list = []  # of the block of checked that is open


def noted_call(name, method):
    """A public method that notes its calls."""

    def called(*arguments, **named):
        calls.append([name, named.get("out") is not None])
        return method(*arguments, **named)

    return called


def noted(module, name, factory):
    """A factory of drivers that notes from where each driver comes."""

    def make(*arguments):
        driver = factory(*arguments)
        sources[driver] = [module.__name__, name, list(arguments)]
        return driver

    return make


class Recorded:
    """A driver whose launches are recorded before they run."""

    def __init__(self, driver, source):
        self.driver, self.source, self.compiled = driver, source, cuda.jit(driver)

    def __getitem__(self, grid):
        def launch(*arguments):
            stream = grid[2] if len(grid) > 2 else 0
            blocks, threads, in_block = int(grid[0]), int(grid[1]), bool(own_streams)
            is_own = any(stream is each for each in own_streams)
            kind = "own" if is_own else "other" if stream else "default"
            given = [described(each) for each in arguments]
            launches.append(
                {"driver": self.source, "arguments": given, "grid": [blocks, threads], "stream": kind, "in_block": in_block}
            )
            self.compiled[grid](*arguments)

        return launch


def described(argument):
    if hasattr(argument, "strides"):
        kind = argument.dtype.type
        dtype = f"{kind.__module__}:{kind.__name__}" if issubclass(kind, Record) else str(argument.dtype)
        return {"dtype": dtype, "shape": argument.shape, "strides": argument.strides}
    if isinstance(argument, tuple | device.Tables):
        kind = type(argument)
        return {"of": f"{kind.__module__}:{kind.__name__}", "parts": [described(each) for each in argument]}
    return {"type": type(argument).__name__, "value": None if argument is None else float(argument)}


def recorded(driver):
    for plain, source in sources.items():
        if driver is plain:
            return Recorded(driver, [*source, False])
        if source[1] not in NEVER_SINGLE and source[2][-1:] != [True] and driver is in_single(plain):
            return Recorded(driver, [*source, True])
    home, name = driver.__module__, driver.__name__
    return Recorded(driver, [home.removesuffix(".single"), name, None, home.endswith(".single")])


NEVER_SINGLE = {  # nor is a driver that searches a BVH: its last argument is true
    *("searches_of", "distances_of", "branches_of", "edges_of"),
    *("gravity_of", "masses_of", "inverse_of", "forward_of", "derivatives_of"),
}


def worlds():
    boxes, shapes = ulna.World(), ulna.World()
    boxes.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.3)))
    shapes.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    return boxes, shapes


def strange(array):
    """The array on the device, with a stride of 0 along axes of length 1, as ``x[None]`` and other libraries have it."""
    array = np.ascontiguousarray(array)
    strides = [0 if n == 1 else stride for n, stride in zip(array.shape, array.strides, strict=True)]
    return cuda.to_device(np.lib.stride_tricks.as_strided(array, array.shape, strides))


def call_everything():
    panda, ur5 = ulna.load("panda"), ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    boxes, shapes = worlds()
    q = np.array([panda.home, panda.home + 0.1])
    T = panda.forward_kinematics(q)
    for on_gpu, number in ((panda.on_gpu(), np.float64), (panda.on_gpu(float32=True), np.float32)):
        wide = q.astype(number)
        for given in (q, q[0], strange(wide), strange(wide[:1])):
            on_gpu.forward_kinematics(given)
            on_gpu.link_poses(given)
            on_gpu.jacobian(given, expressed_in="link")
            on_gpu.in_collision(given, boxes)
        on_gpu.in_collision(strange(wide[:1]), shapes)
        on_gpu.signed_distance(strange(wide[:1]), boxes)
    on_gpu = panda.on_gpu()
    on_gpu.in_collision(q[:1])
    on_gpu.signed_distance(q[:1], shapes)
    on_gpu.edge_in_collision(strange(q[:1]), strange(q[1:]), boxes)
    on_gpu.plan_many(q[:1], q[1:], boxes, clearance=0.001)
    call_with_many_solids(on_gpu, q)
    call_forces(on_gpu, q)
    call_forces(panda.on_gpu(float32=True), q.astype(np.float32))
    on_gpu.inverse_kinematics(T[0], q[0])
    on_gpu.inverse_kinematics(strange(T), q, world=boxes)
    on_gpu.inverse_kinematics(strange(T[:1]), world=shapes, task="position")
    on_gpu.inverse_kinematics(strange(T[:1]), task=ulna.Task.pointing((1.0, 0.0, 0.0)))
    on_gpu.all_solutions(T[:1], n_samples=1)
    targets = ur5.forward_kinematics(ur5.home + 0.1)
    for given in (targets, targets[None], strange(targets[None])):
        ur5.on_gpu().all_solutions(given)
    ur5.on_gpu(float32=True).all_solutions(strange(targets[None].astype(np.float32)))
    call_with_float32(panda.on_gpu(float32=True), q, T, boxes)
    for call in (on_gpu, panda.on_gpu(float32=True)):
        call_with_results(call, q, boxes)
        call_without_rows(call, ur5.on_gpu(float32=call.float32), boxes)
    call_in_a_block(on_gpu, ur5, q, boxes, shapes)


def call_with_float32(on_gpu, q, T, boxes):
    """The methods that compute in float64, over arrays of float32."""
    q, T = q.astype(np.float32), T.astype(np.float32)
    on_gpu.inverse_kinematics(strange(T[:1]), world=boxes)
    on_gpu.inverse_kinematics(strange(T))
    on_gpu.signed_distance(strange(q), boxes)
    on_gpu.edge_in_collision(strange(q), strange(q[::-1]), boxes)


def call_with_results(on_gpu, q, boxes):
    """Every method that has ``out``, with an array on the device, and on the host."""
    wide, n_links = q.astype(np.float32 if on_gpu.float32 else np.float64), len(on_gpu.robot.tree.link_frames)
    shapes = {
        "forward_kinematics": (4, 4), "link_poses": (n_links, 4, 4), "jacobian": (6, 7), "in_collision": (),
        "signed_distance": (), "gravity_torque": (7,), "mass_matrix": (7, 7), "inverse_dynamics": (7,), "forward_dynamics": (7,),
    }  # fmt: skip
    of_input = "forward_kinematics", "link_poses", "jacobian"
    for name, shape in shapes.items():
        kind = np.bool_ if name == "in_collision" else wide.dtype if name in of_input else np.float64
        arguments = 3 if name in {"inverse_dynamics", "forward_dynamics"} else 1
        more = (boxes,) if name in {"in_collision", "signed_distance"} else ()
        out = np.empty((len(q), *shape), kind)
        getattr(on_gpu, name)(*(wide,) * arguments, *more, out=out)
        getattr(on_gpu, name)(*(strange(wide),) * arguments, *more, out=cuda.to_device(out))


def call_without_rows(on_gpu, six, boxes):
    """No rows at all: a grid without blocks is refused by a card."""
    kind = np.float32 if on_gpu.float32 else np.float64
    q, T = cuda.device_array((0, 7), kind), cuda.device_array((0, 4, 4), kind)
    on_gpu.forward_kinematics(q)
    on_gpu.in_collision(q, boxes)
    on_gpu.edge_in_collision(q, q, boxes)
    on_gpu.inverse_dynamics(q, q, q)
    on_gpu.inverse_kinematics(T, world=boxes)
    six.all_solutions(T)


@contextmanager
def block_of(on_gpu):
    """A block of ``checked`` with a stream of its own."""
    own_streams.append(cuda.stream())
    try:
        with on_gpu.checked(own_streams[-1]):
            yield
    finally:
        own_streams.pop()


def call_in_a_block(on_gpu, ur5, q, boxes, shapes):
    """Arrays on the device within ``checked``."""
    q, six = strange(q), ur5.on_gpu()
    clouds = ulna.World()
    for k in range(2):
        points = np.random.default_rng(k).uniform(-0.8, 0.8, (40, 3))
        clouds.add(f"cloud {k}", ulna.PointCloud(points, 0.02))
    with block_of(on_gpu):
        T = on_gpu.forward_kinematics(q)
        on_gpu.link_poses(q)
        on_gpu.jacobian(q)
        on_gpu.in_collision(q, boxes)
        on_gpu.signed_distance(q, shapes)
        on_gpu.edge_in_collision(q, q, boxes)
        on_gpu.inverse_kinematics(T, world=boxes)
        on_gpu.inverse_kinematics(T, task=ulna.Task.pointing((1.0, 0.0, 0.0)))
        with mock.patch.object(scenes, "MAX_ONE_BY_ONE", 10):
            on_gpu.in_collision(q, clouds)
        call_forces_of(on_gpu, q)
    with block_of(six):
        six.all_solutions(six.forward_kinematics(cuda.to_device(ur5.home[None] + 0.1)))


def call_with_many_solids(on_gpu, q):
    cloud, terrain = ulna.World(), ulna.World()
    cloud.add("cloud", ulna.PointCloud(np.random.default_rng(0).uniform(-0.8, 0.8, (40, 3)), 0.02))
    terrain.add("ground", ulna.HeightMap(np.zeros((5, 5)), 0.3, bottom=-0.1))
    stones = cloud.copy()
    stones.add("stone", ulna.ConvexMesh(np.random.default_rng(5).normal(scale=0.1, size=(12, 3))))
    with mock.patch.object(scenes, "MAX_ONE_BY_ONE", 10):
        for world in (cloud, terrain, stones):
            on_gpu.in_collision(strange(q[:1]), world)
            on_gpu.signed_distance(q, world)
        on_gpu.edge_in_collision(strange(q[:1]), strange(q[1:]), cloud)


def call_forces(on_gpu, q):
    for given in (q, q[0], strange(q), strange(q[:1])):
        call_forces_of(on_gpu, given)


def call_forces_of(on_gpu, q):
    on_gpu.gravity_torque(q)
    on_gpu.mass_matrix(q)
    on_gpu.inverse_dynamics(q, q, q)
    on_gpu.forward_dynamics(q, q, q)
    on_gpu.inverse_dynamics_derivatives(q, q, q)


if __name__ == "__main__":
    with ExitStack() as stack:
        for module in MODULES:
            for name, factory in list(vars(module).items()):
                if isinstance(factory, _lru_cache_wrapper) and name.endswith("_of"):
                    home = importlib.import_module(factory.__wrapped__.__module__)
                    stack.enter_context(mock.patch.object(module, name, noted(home, name, factory)))
        stack.enter_context(mock.patch.object(device, "compiled", recorded))
        for name in public_methods():
            stack.enter_context(mock.patch.object(GpuRobot, name, noted_call(name, getattr(GpuRobot, name))))
        call_everything()
    json.dump({"launches": launches, "calls": calls}, sys.stdout)
