"""``ulna run``: a dry run, what is refused, and that nothing moves unless the user says so."""

import json

import numpy as np
import pytest

GOAL = "0.4,-0.6,0,-2.2,0,1.6,0.8"


def test_a_dry_run_ends_at_the_goal_and_its_commands_are_written(run, tmp_path):
    result = run("run", "franka", "--dry-run", "--to", GOAL, "--csv", tmp_path / "run.csv")
    assert result.exit_code == 0, result.output
    assert "at the goal" in result.output
    rows = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    assert np.allclose(rows[-1, 1:8], [0.4, -0.6, 0, -2.2, 0, 1.6, 0.8])
    assert np.allclose(np.diff(rows[:, 0]), 0.001)


def test_a_lower_speed_takes_longer(ask):
    slow, fast = (ask("run", "franka", "--dry-run", "--to", GOAL, "--speed", speed) for speed in ("0.1", "1"))
    assert slow.duration == pytest.approx(10 * fast.duration)
    assert slow.moved
    assert slow.tracking_error == 0.0
    assert np.allclose(slow.q, slow.path[-1])


def test_nothing_is_run_where_there_is_no_plan(run):
    result = run("run", "franka", "--dry-run", "--to", GOAL, "--box", "0.3,0.1,0.5,0,0,0,0.4,0.4,0.4", "--json")
    assert result.exit_code == 1
    data = json.loads(result.stdout)
    assert not data["moved"]
    assert data["duration"] is None


@pytest.mark.parametrize(
    "options",
    [
        ("--dry-run", "--to", GOAL, "--speed", "1.5"),
        ("--dry-run", "--to", GOAL, "--speed", "nan"),
        ("--dry-run", "--to", "0,0,0"),
        ("--to", GOAL, "--from", GOAL),
        ("--to", GOAL, "--json"),
    ],
)
def test_other_options_are_refused(run, options):
    assert run("run", "franka", *options).exit_code == 2


def test_the_arm_moves_only_after_a_yes(run, monkeypatch):
    from ulna.arms import Recorder
    from ulna.cli import run as command
    from ulna.robot import load

    arm = Recorder(load("fr3").home)
    monkeypatch.setattr(command, "Franka", lambda *_, **__: arm)
    result = run("run", "franka", "--to", GOAL)  # nobody answers: standard input is empty
    assert result.exit_code == 1
    assert arm.records == []
    assert run("run", "franka", "--to", GOAL, "--yes").exit_code == 0
    assert len(arm.records) == 1
