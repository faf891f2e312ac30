"""The plots and the account of ``make bench``, judged on a run that is made up."""

import numpy as np
import pytest
from benchmarks import account, bounds, collision, plots, scaling
from benchmarks.peers import coal

import ulna

RUN = {
    "scaling_with_joints": [
        {"work": work, "joints": n, "one_ns": 500.0 + n, "batch_ns": 3.0 * n, "bound_ns": 1.0 * n}
        for work in ("forward_kinematics", "jacobian")
        for n in (3, 60)
    ],
    "scaling_with_pairs": [
        {"world": world, "pairs": pairs, "batch_ns": 8.0 * pairs, "distance_ns": 90.0 * pairs, "bound_ns": bound}
        for world in plots.WORLDS
        for pairs, bound in ((12, 20.0), (3072, None))
    ],
    "scaling_with_rows": [],
}


def test_each_subject_that_was_measured_gets_a_plot_and_twice_the_same_one(tmp_path):
    paths = plots.draw(RUN, tmp_path)
    assert [path.name for path in paths] == ["joints.svg", "pairs.svg"]
    first = [path.read_bytes() for path in paths]
    assert all(b"</svg>" in text for text in first)
    assert [path.read_bytes() for path in plots.draw(RUN, tmp_path)] == first


def test_each_part_of_a_call_is_what_one_layer_takes_more_than_the_layer_below_it():
    times = {"loop": 10, "fk method": 200, "fk bound": 150, "fk out": 120, "fk kernel": 90, "fk idle": 40, "jac method": 9e9}
    assert account._row("forward_kinematics", "fk", times) == {
        "work": "forward_kinematics",
        "into_compiled_code_ns": 30,
        "arithmetic_ns": 50,
        "bound_function_ns": 30,
        "new_array_ns": 40,
        "method_ns": 50,
        "whole_call_ns": 200,
    }


@pytest.mark.compiler
def test_the_account_is_of_one_pose_and_one_jacobian(panda):
    assert [row["work"] for row in account.account_rows(panda)] == ["forward_kinematics", "jacobian"]


def test_more_pairs_need_more_operations_and_a_tree_has_no_such_bound(panda, monkeypatch):
    monkeypatch.setattr(collision, "BOXES", (1, 3, 65))
    monkeypatch.setattr(collision, "N", 64)
    one, three, indexed = (row for row in collision.growth_rows(panda, peak=1.0) if row["world"] == "as dense")
    assert (one["pairs"], three["pairs"], indexed["bound_ns"]) == (12, 36, None)
    counts = bounds.count_operations(panda, with_boxes=True)
    assert three["bound_ns"] - one["bound_ns"] == pytest.approx(24 * counts["balls_overlap"] / 8)
    assert counts["boxes_overlap"] > 5 * counts["balls_overlap"] > 0


def test_a_scene_with_a_different_verdict_is_not_timed(panda, monkeypatch):
    q, world = np.random.default_rng(0).uniform(panda.lower, panda.upper, (100, 7)), collision.scattered(20, 0.2, 0.8)
    scene = coal.Scene(panda, world, itself=True)
    assert coal.disagreement(scene, panda, world, q, itself=True) == ""
    assert coal.disagreement(scene, panda, world, q, itself=False).endswith("verdicts differ")
    monkeypatch.setattr(scene, "least_distance", lambda x: panda.signed_distance(x, world) + 1e-4)
    assert coal.disagreement(scene, panda, world, q, itself=True) == "its distances differ by 1.0e-04 m"


def test_a_longer_arm_has_a_higher_bound():
    assert isinstance(scaling.random_arm(3), ulna.Robot)
    short, long = (bounds.count_operations(scaling.random_arm(n))["jacobian"] for n in (3, 6))
    assert long > 1.8 * short
