"""``ulna plan``: what it prints and writes, and its exit status."""

import json

import numpy as np
import pytest

import ulna

RIGHT = "-1,-pi/4,0,-3pi/4,0,pi/2,pi/4"
LEFT = "1,-pi/4,0,-3pi/4,0,pi/2,pi/4"


@pytest.fixture
def scene(tmp_path):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    ulna.save_world(world, tmp_path / "cell.json")
    return str(tmp_path / "cell.json")


def test_a_plan_is_printed_and_its_motion_written(run, scene, tmp_path):
    result = run("plan", "--from", LEFT, "--to", RIGHT, "--scene", scene, "--csv", str(tmp_path / "motion.csv"))
    assert result.exit_code == 0, result.output
    assert "certified free" in result.output
    rows = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert rows.shape[1] == 22
    assert np.allclose(rows[0, 1:8], [1, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
    panda = ulna.load("panda")
    assert not panda.in_collision(np.ascontiguousarray(rows[:, 1:8]), ulna.load_world(scene)).any()


def test_json_has_the_path_and_why_there_is_none(run, scene):
    found = json.loads(run("plan", "--from", LEFT, "--to", RIGHT, "--scene", scene, "--json").stdout)
    assert found["success"]
    assert np.array(found["path"]).shape[1] == 7
    assert found["duration"] > 0
    result = run("plan", "--from", LEFT, "--xyz", "3,0,0", "--scene", scene, "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["status"] == "goal unreachable"


def test_one_goal_is_expected(run):
    assert run("plan").exit_code == 2
    assert run("plan", "--to", RIGHT, "--xyz", "0.4,0,0.4").exit_code == 2
    assert run("plan", "--goal", "panda_ee=0.4,0,0.4", "--xyz", "0.4,0,0.4").exit_code == 2
