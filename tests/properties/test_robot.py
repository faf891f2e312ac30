"""A robot cannot be changed, survives pickling, and may be asked by many threads at once."""

import copy
import os
import pickle
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import robots
import ulna
from ulna.robot.other_names import OTHER_NAMES

SHOWN = ("lower", "upper", "velocity_limits", "home")
COPIES = {
    "pickle": lambda robot: pickle.loads(pickle.dumps(robot)),  # noqa: S301
    "pickle, twice": lambda robot: pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(robot)))),  # noqa: S301
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}
N_THREADS = 8


def arrays_of(robot):
    """Every array that a robot shows, by its name."""
    found = {name: getattr(robot, name) for name in SHOWN}
    for joint in robot.description.joints:
        found |= {f"{joint.name} origin": joint.origin, f"{joint.name} axis": joint.axis}
    for link in robot.description.links:
        found |= {f"{link.name} {body.name} pose": body.pose for body in (*link.visuals, *link.collisions)}
    return found


@pytest.fixture(params=["panda", "every joint", "dh"])
def robot(request, panda):
    arm = ulna.Robot.from_dh([(0, 0.3, 0, 0), (0.2, 0, 1.5, 0.1)], limits=[(-1, 1), (-2, 2)])
    return {"panda": panda, "every joint": ulna.Robot(robots.every_joint()), "dh": arm}[request.param]


def test_nothing_of_it_can_be_set_or_deleted(robot):
    for name in ("name", "n_dof", "tip", "tree", "description", "color", *SHOWN):
        with pytest.raises(AttributeError, match=f"a Robot cannot be changed: {name}"):
            setattr(robot, name, None)
    for name in ("home", "tree"):
        with pytest.raises(AttributeError, match=f"a Robot cannot be changed: del {name}"):
            delattr(robot, name)


@pytest.mark.parametrize("name", OTHER_NAMES)
def test_a_name_of_another_library_leads_to_the_call_to_write(panda, name):
    with pytest.raises(AttributeError, match=f"^a Robot has no '{name}'; write ") as refused:
        getattr(panda, name)
    assert refused.value.name == name
    assert not hasattr(panda, name)
    assert getattr(panda, name, None) is None
    assert name not in dir(panda)
    if "view" not in (instead := str(refused.value).partition("; write ")[2]):
        around = {"robot": panda, "q": panda.home, "world": ulna.World(), "T_base_tip": panda.forward_kinematics(panda.home)}
        around |= dict.fromkeys(("qd", "qdd", "torque"), np.zeros(7))
        for call in re.split(r" and |, or ", instead):
            eval(call, around)  # noqa: S307 - a call of ours


def test_a_name_that_no_library_has_is_refused_as_ever(panda):
    with pytest.raises(AttributeError, match=r"^'Robot' object has no attribute 'color'"):
        _ = panda.color


def test_every_array_that_it_shows_is_read_only(robot):
    assert [name for name, array in arrays_of(robot).items() if array.flags.writeable] == []
    with pytest.raises(ValueError, match="read-only"):
        robot.home[0] = 1.0


@pytest.mark.parametrize("way", COPIES)
def test_a_copy_computes_the_same_bits(robot, rng, way):
    q = rng.uniform(-1, 1, (9, robot.n_dof))
    link = robot.link_names[-1]
    before = robot.link_poses(q), robot.jacobian(q, link=link)
    same = COPIES[way](robot)
    assert same.link_poses(q).tobytes() == before[0].tobytes()
    assert same.jacobian(q, link=link).tobytes() == before[1].tobytes()
    for name in ("name", "joint_names", "link_names", "base", "tip", "joint_slices"):
        assert getattr(same, name) == getattr(robot, name)
    assert all(np.array_equal(getattr(same, name), getattr(robot, name)) for name in SHOWN)


@pytest.mark.parametrize("way", COPIES)
def test_a_copy_is_as_unchangeable(robot, way):
    same = COPIES[way](robot)
    assert [name for name, array in arrays_of(same).items() if array.flags.writeable] == []
    with pytest.raises(AttributeError):
        same.home = None


def test_a_copy_solves_and_collides_alike(panda, rng):
    q = rng.uniform(panda.lower, panda.upper, (9, 7))
    world = ulna.World()
    world.add("crate", ulna.Box((0.4, 0.4, 0.4)), ulna.pose((0.4, 0, 0.5)))
    same, same_world = pickle.loads(pickle.dumps((panda, world)))  # noqa: S301
    T = panda.forward_kinematics(q)
    assert same.inverse_kinematics(T).q.tobytes() == panda.inverse_kinematics(T).q.tobytes()
    assert np.array_equal(same.in_collision(q, same_world), panda.in_collision(q, world))
    same_world.remove("crate")
    assert world.names == ("crate",)


def test_the_result_depends_on_the_seed_and_on_nothing_else(panda, rng):
    # With a rank random starts are tried, also where a closed form has solutions.
    T = panda.forward_kinematics(rng.uniform(panda.lower, panda.upper, (20, 7)))
    first = panda.inverse_kinematics(T, rank="mid_range", seed=1)
    np.random.seed(0)  # noqa: NPY002
    panda.inverse_kinematics(T, rank="mid_range", seed=2)
    assert panda.inverse_kinematics(T, rank="mid_range", seed=1).q.tobytes() == first.q.tobytes()
    assert panda.inverse_kinematics(T, rank="mid_range", seed=2).q.tobytes() != first.q.tobytes()


IN_A_FRESH_PROCESS = """
import threading, numpy as np, ulna
robot = ulna.load("panda")
q = np.random.default_rng(1).uniform(robot.lower, robot.upper, (20, 7))
start, answers = threading.Barrier(8), []
def ask():
    start.wait()
    T = robot.forward_kinematics(q)
    answers.append(T.tobytes().hex() + robot.inverse_kinematics(T).q.tobytes().hex())
threads = [threading.Thread(target=ask) for _ in range(8)]
[t.start() for t in threads]
[t.join() for t in threads]
assert len(answers) == 8
print(*set(answers))
"""


@pytest.mark.process
def test_threads_that_are_the_first_to_ask_get_the_result_of_any_other_process(panda):
    environment = {**os.environ, "PYTHONPATH": str(Path(ulna.__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", IN_A_FRESH_PROCESS], env=environment, capture_output=True, text=True, check=True)
    T = panda.forward_kinematics(np.random.default_rng(1).uniform(panda.lower, panda.upper, (20, 7)))
    assert done.stdout.split() == [T.tobytes().hex() + panda.inverse_kinematics(T).q.tobytes().hex()]


def test_eight_threads_get_the_bits_of_one(panda, rng):
    T = panda.forward_kinematics(rng.uniform(panda.lower, panda.upper, (40, 7)))

    def ask(k):
        s = panda.inverse_kinematics(T, seed=k % 3)
        return s.q.tobytes(), s.iterations.tobytes(), panda.link_poses(s.q).tobytes(), panda.jacobian(s.q).tobytes()

    alone = [ask(k) for k in range(3)]
    with ThreadPoolExecutor(N_THREADS) as pool:
        assert list(pool.map(ask, range(10 * N_THREADS))) == [alone[k % 3] for k in range(10 * N_THREADS)]


def test_a_world_that_changes_meanwhile_is_seen_as_it_was_at_one_moment(panda):
    world, here, away = ulna.World(), ulna.pose((0.0, 0.0, 0.3)), ulna.pose((5.0, 0.0, 0.0))
    box = ulna.Box((0.1, 0.1, 0.1))
    world.add("a", box, here)

    def change():
        for k in range(400):
            world.add(f"b{k}", box, away)
            world.move("a", away if k % 2 else here)
            world.remove(f"b{k}")

    def ask(_):
        return panda.in_collision(panda.home, world), {pair.name_b for pair in panda.check_collision(panda.home, world).pairs}

    with ThreadPoolExecutor(N_THREADS) as pool:
        changing = pool.submit(change)
        answers = list(pool.map(ask, range(500)))
        changing.result()
    assert all(names <= {"a"} for _, names in answers), "a name was given to the box of another"
    assert ask(0) == (False, set())
    world.move("a", here)
    assert ask(0) == (True, {"a"})
