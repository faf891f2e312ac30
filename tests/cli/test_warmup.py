"""``ulna warmup``: it compiles every entry for every signature, so that nothing is compiled afterwards."""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ulna.engine import warmup
from ulna.engine.decorators import ENTRIES
from ulna.engine.entries import Entries

pytestmark = pytest.mark.compiler

# Makes calls of every kind. Then prints the signatures that were used but not declared, and those declared but not used.
CALLS = """
import json, sys
from pathlib import Path
import numpy as np
import ulna
from ulna.collision.entries import placing
from ulna.engine import bound
from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES
from ulna.planning.jerk_limited import timed_path
from ulna.planning.blend import Certificate
from ulna.planning.timing import Limits
from ulna.viewer.film.recording import make_form, record_robot
bound._called_directly = lambda entry, *_: entry  # or a type that is not declared would not be seen
panda, world, mixed = ulna.load("panda"), ulna.World(), ulna.World()
box = ulna.Box((0.1, 0.1, 0.1))
world.add("crate", box, ulna.pose((0.4, 0, 0.4)))
for kind in ("float32", "float64"):
    cloud = ulna.PointCloud(np.full((9, 3), 2.0, kind), 0.01)
    mixed.add(kind, cloud.thinned(0.1).without(panda, panda.home))
ulna.PointCloud(np.arange(3000.0).reshape(-1, 3), 0.01).thinned(1.0)  # its table has to grow
for k in range(80):
    mixed.add(f"ball {k}", ulna.Sphere(0.01) if k % 2 else ulna.Cylinder(0.01, 0.1), ulna.pose((0.5, 0.02 * k, 0.4)))
placing.copy_exact(np.eye(4), np.empty((4, 4)))  # which only a wheel calls
floor = ulna.HalfSpace()
mixed.add("floor", floor, ulna.pose((0, 0, -0.1)))
hull = panda.with_attached("tool", ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]), np.eye(4))
held = panda.with_attached("cup", ulna.Cylinder(0.03, 0.1), np.eye(4))
ready = panda.home + 0.1
batch = np.tile(ready, (9, 1))
target, targets = panda.forward_kinematics(panda.home), panda.forward_kinematics(batch)
for q in (ready, batch, batch.tolist(), np.broadcast_to(ready, (2, 3, 7)), batch[:, ::-1], batch.astype(np.float32)):
    panda.forward_kinematics(q), panda.forward_kinematics(q, link="panda_link3"), panda.link_poses(q), panda.collision_poses(q)
    panda.jacobian(q), panda.analytical_jacobian(q), panda.manipulability(q)
    panda.differential_ik(q, np.ones(6), 0.01)
    for robot, scene in ((panda, world), (panda, None), (panda, mixed), (held, world), (hull, mixed)):
        for self_collision in (True, False) if scene else (True,):
            ask = {"self_collision": self_collision}
            robot.in_collision(q, scene, **ask), robot.signed_distance(q, scene, **ask)
            robot.distance_gradient(q, scene, **ask)
        robot.check_collision(q, scene, max_distance=0.1), robot.distances(q, scene)
        robot.edge_in_collision(q, panda.home, scene)
        robot.servo(scene, acceleration=1.0).warm_up()
panda.inverse_dynamics(batch, batch, ready), panda.gravity_torque(ready), panda.inverse_dynamics_derivatives(batch, ready, ready)
panda.mass_matrix(ready), panda.forward_dynamics(batch, ready, ready), panda.center_of_mass(ready)
panda.differential_ik(panda.home, np.ones((4, 6)), 0.01)
panda.inverse_kinematics(target), panda.inverse_kinematics(targets, panda.home)
panda.inverse_kinematics(target, panda.home, posture="mid_range", trace=True)
panda.inverse_kinematics(targets, batch, max_step=0.5, held=["panda_joint1"])
panda.inverse_kinematics(target, world=mixed, rank="clearance"), panda.inverse_kinematics(target, task="pointing", rank="nearest")
panda.all_solutions(target, rank="nearest")
str(panda.allowed_collisions), str(held.with_tool(np.eye(4)).allowed_collisions)
half = np.pi / 2
rows = [(0, 0.09, half, 0), (-0.43, 0, 0, 0), (-0.39, 0, 0, 0), (0, 0.11, half, 0), (0, 0.09, -half, 0), (0, 0.08, 0, 0)]
for n in (6, 5):
    arm = ulna.Robot.from_dh(rows[:n], convention="standard")
    some = arm.forward_kinematics(np.tile(arm.home + 0.3, (9, 1)))
    for T in (some, some[0]):
        arm.inverse_kinematics(T), arm.all_solutions(T)
for robot, scene in ((panda, world), (held, mixed)):
    plan = robot.plan(ready, ready + 0.2, scene)
    robot.plan(ready, ready + 0.1, scene, keep=ulna.Keep.upright(within=1.0))
    plan.trajectory(acceleration=1.0)
panda.edge_keeps(ready, ready + 0.01, ulna.Keep.upright())
there = panda.inverse_kinematics(panda.forward_kinematics(panda.home) @ ulna.pose((0, 0.1, 0)), panda.home).q
panda.plan(panda.home, there, keep=ulna.Keep.orientation(within=1e-3)).trajectory(acceleration=1.0, jerk=10.0)
corner = np.array([ready, ready + 0.2, ready + 0.2 * (-1.0) ** np.arange(7)])
limits = Limits(np.full(7, 1.0), np.full(7, 1.0), np.full(7, 10.0))
timed_path(corner, np.linalg.norm(np.diff(corner, axis=0), axis=1), 0.1, limits, Certificate(lambda *_: True))
record_robot(make_form(Path(sys.argv[1]), 0.1, (64, 36)), panda, panda.home)
declared = {entry.py_func.__name__: set(map(numba_types, calls.signatures)) for entry, calls in ENTRIES.items()}
used = {entry.py_func.__name__: set(entry.signatures) for entry in ENTRIES}
print(json.dumps({
    "undeclared": [f"{name}{call}" for name in declared for call in used[name] - declared[name]],
    "unused": [f"{name}{call}" for name in declared for call in declared[name] - used[name]],
}))
"""


# The command with three entries only: all of them would take a minute or two.
SOME = """
import sys
from ulna.engine import warmup
every = warmup.all_jobs
chosen = [f"kinematics.entries.{name}" for name in ("forward.forward_one", "forward.forward_batch", "jacobian.jacobian_one")]
warmup.all_jobs = lambda entries: [job for job in every(entries) if job.name in chosen]
from ulna.cli.app import app
app(["warmup", *sys.argv[1:]], prog_name="ulna")
"""
POSES = """
import ulna
from ulna.engine.decorators import ENTRIES
panda = ulna.load("panda")
panda.forward_kinematics(panda.home), panda.forward_kinematics([panda.home] * 9), panda.jacobian(panda.home)
print(sum(sum(entry.stats.cache_misses.values()) for entry in ENTRIES))
"""


def run(*arguments, **variables):
    environment = {**os.environ, "TERM": "dumb", **variables}
    return subprocess.run([sys.executable, "-c", *arguments], capture_output=True, text=True, check=True, env=environment)


@pytest.mark.slow
@pytest.mark.timeout(900)  # on a machine that has compiled nothing yet, with the other tests beside it
def test_each_entry_declares_exactly_the_signatures_it_is_called_with(tmp_path):
    """Warmup compiles the declared signatures, so these must be complete."""
    assert json.loads(run(CALLS, str(tmp_path / "film.mp4")).stdout) == {"undeclared": [], "unused": []}


@pytest.mark.slow
def test_nothing_is_compiled_after_warmup(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path)}
    first = run(SOME, "--json", **cache)
    data = json.loads(first.stdout)
    assert first.stderr == ""
    assert {row["entry"] for row in data["compiled"] if not row["was_cached"]} == {"forward_one", "forward_batch", "jacobian_one"}
    assert any(Path(data["folder"]).glob("*.nbc"))
    assert Path(data["folder"]).is_relative_to(tmp_path)
    assert run(POSES, **cache).stdout == "0\n"
    again = run(SOME, **cache)
    assert "0 of 3 compiled" in again.stdout
    assert "1 of 3: " in again.stderr


@pytest.mark.process
def test_warmup_covers_every_module_of_entries():
    """Entries of modules that are not yet imported are included."""
    code = """
from ulna.engine.entries import Entries
from ulna.engine.warmup import all_jobs
print(*{job.name for job in all_jobs(Entries("ulna"))})
"""
    found = run(code).stdout.split()
    modules = Entries("ulna").modules()
    assert len(modules) > 20
    for module in modules:
        place, functions = module.removeprefix("ulna."), vars(importlib.import_module(module)).items()
        own = {f"{place}.{name}" for name, value in functions if callable(value) and value in ENTRIES}
        assert own == {name for name in found if name.rpartition(".")[0] == place}


def test_every_signature_is_one_job():
    entries = Entries("ulna")
    jobs = warmup.all_jobs(entries)
    assert len(set(jobs)) == len(jobs) == sum(len(ENTRIES[entries.marked(name)].signatures) for name in entries.names())


@pytest.mark.process
def test_a_cache_folder_that_cannot_be_written_is_an_error(tmp_path):
    file = tmp_path / "file"
    file.touch()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(file / "below")}
    done = subprocess.run([sys.executable, "-m", "ulna", "warmup"], capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("ulna: cache folder: it cannot be written")


@pytest.mark.process
def test_importing_the_warmup_command_does_not_import_numba():
    code = "import sys, ulna.cli.warmup, ulna.cli.app; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
