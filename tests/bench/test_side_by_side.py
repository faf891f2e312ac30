"""``make bench``: what stands around the peers, judged without most of them (pin is here; the others need not be)."""

import os
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks import bounds, guard, ik_branches, markdown, peer
from benchmarks.inverse import protocol_rows
from benchmarks.kinematics import batch_rows, single_call_rows
from benchmarks.peers import pinocchio
from benchmarks.processors import one_processor
from benchmarks.scaling import random_arm

import ulna
from ik_methods import valid_solutions
from ulna.bench.arms import load_arm, random_positions
from ulna.bench.protocol import PROTOCOLS, Solver, ulna_solver
from ulna.engine.threads import default_threads, in_parts

PI = np.pi


@pytest.mark.parametrize("name", ["panda", "jaco2", "pr2"])
def test_pinocchio_computes_the_same_for_arms_with_and_without_limits(name):
    made, why = peer.make_peer("pin", load_arm(name))
    assert made is not None, why


def test_a_peer_that_is_not_installed_is_named(panda, monkeypatch):
    monkeypatch.setitem(sys.modules, "pytracik", None)
    monkeypatch.delitem(sys.modules, "benchmarks.peers.tracik", raising=False)
    made, why = peer.make_peer("pytracik", panda)
    assert made is None
    assert why.startswith("absent: ")


def test_a_peer_that_computes_something_else_is_not_timed(panda):
    wrong = peer.Peer(forward=lambda q: panda.forward_kinematics(q) + 1e-6)
    assert peer.check(wrong, panda) == (None, "its poses differ by 1.0e-06")
    turned = peer.Peer(jacobian=lambda q: panda.jacobian(q, expressed_in="link"))
    assert peer.check(turned, panda)[1].startswith("its Jacobians differ")
    shuffled = peer.Peer(forward_batch=lambda q: panda.forward_kinematics(q)[::-1])
    assert peer.check(shuffled, panda)[1].startswith("its poses of a batch differ")
    right = peer.Peer(forward=panda.forward_kinematics, jacobian_batch=panda.jacobian)
    assert peer.check(right, panda) == (right, "")


def test_a_tip_fixed_to_ours_is_found_and_another_arm_is_refused(panda):
    T = ulna.pose((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    np.testing.assert_allclose(peer.standing_offset(panda, lambda q: panda.forward_kinematics(q) @ T), T, atol=1e-12)
    with pytest.raises(peer.NotForThisArm):
        peer.standing_offset(panda, lambda q: panda.forward_kinematics(1.001 * q))


@pytest.mark.parametrize(
    ("limits", "angle", "expected"),
    [
        ((-3, 3), 6.0, 6 - 2 * PI),
        ((-3, 3), -6.0, 2 * PI - 6),
        ((4, 7), 0.5, 0.5 + 2 * PI),
        ((-1, 1), 2.0, None),
        ((-9, 9), 8.0, -9),
    ],
)
def test_whole_turns_bring_a_joint_into_its_limits(limits, angle, expected):
    arm = ulna.Robot.from_dh([(0, 0, 0, 0)], limits=[limits])
    turned = peer.within_limits_by_turns(arm, np.array([angle]))
    if expected is None:
        assert turned is None
    else:
        assert limits[0] <= turned[0] <= limits[1]
        assert np.cos(turned[0] - angle) == pytest.approx(1.0)


def test_the_urdf_for_the_peers_has_no_shapes_and_full_limits(panda):
    text = peer.bare_urdf(ulna.Robot.from_dh([(0, 0, 0, 0)], limits=[(-1, 1)]))
    assert 'effort="1"' in text
    assert 'velocity="1"' in text
    assert "<visual" not in peer.bare_urdf(panda)
    assert peer.bare_urdf(panda).count("effort=") == panda.n_dof


def test_single_calls_and_batches_have_a_row_for_each_library(panda):
    peers = {"pin": pinocchio.make(panda), "silent": peer.Peer()}
    rows = single_call_rows("panda", panda, peers, "forward_kinematics")
    assert [row["library"] for row in rows] == ["ulna", "ulna, bound", "ulna, bound, out=", "pin", "pin, placement kept"]
    assert rows[0]["times_ulna"] == 1.0
    assert [row["library"] for row in batch_rows("panda", panda, peers, "jacobian")] == ["ulna", "pin, in a loop"]


def test_every_solver_has_a_row_on_the_same_targets(panda):
    seen = []
    silent = Solver("silent", lambda T, _: seen.append(T), lambda _: None)
    forward = pinocchio.Model(panda).forward_all
    rows = protocol_rows("panda", panda, "reachable", [ulna_solver(panda, PROTOCOLS["reachable"]), silent], 60, forward)
    assert [(row["library"], row["targets"], row["solved_percent"]) for row in rows] == [("ulna", 60, 100.0), ("silent", 60, 0.0)]
    targets = PROTOCOLS["reachable"].targets(panda, 60)
    assert {T.tobytes() for T in seen} == {T.tobytes() for T in targets}


def test_rows_become_a_table_in_markdown():
    text = markdown.table([{"name": "a", "time_ns": 1234.5, "count": 2}, {"name": "b", "time_ns": 0.12345, "count": 20_000}])
    assert text.split("\n") == [
        "| name | time ns | count |",
        "| --- | ---: | ---: |",
        "| a | 1,234 | 2 |",
        "| b | 0.1235 | 20,000 |",
    ]


def test_on_one_processor_nothing_is_handed_to_threads_and_afterwards_all_is_as_it_was():
    allowed, before = default_threads(), os.sched_getaffinity(0)
    threads = set()
    with one_processor():
        assert in_parts(lambda _: threads.add(threading.get_ident()) is None, 10_000, 1000)
        assert (default_threads(), len(os.sched_getaffinity(0))) == (1, 1)
    assert threads == {threading.get_ident()}
    assert (default_threads(), os.sched_getaffinity(0)) == (allowed, before)


@pytest.mark.slow
def test_each_joint_more_costs_the_same_number_of_operations():
    counts = [bounds.count_operations(random_arm(joints)) for joints in (2, 3, 4)]
    for kind in ("forward_kinematics", "jacobian"):
        few, more, most = (count[kind] for count in counts)
        assert more - few == most - more > 36  # the product of two poses alone is 36 multiplications


def test_a_slower_work_is_named_and_one_that_is_gone_too():
    rows = guard.compare({"a": 1.0, "b": 1.0, "c": 1.0, "d": 1.0}, {"a": 1.1, "b": 2.0, "c": 0.5, "e": 1.0})
    assert {name: word for name, _, _, word in rows} == {"a": "", "b": "slower", "c": "quicker", "d": "gone", "e": "new"}


class TestBranches:
    """A finder against an oracle, on the UR5e."""

    rows = ik_branches.UR5E[0]

    @pytest.fixture
    def arm(self):
        return ulna.Robot.from_dh(self.rows, convention="standard", limits=ik_branches.UR5E[1])

    def test_the_dh_product_is_the_arm(self, arm):
        q = random_positions(arm, 1, 0)[0]
        np.testing.assert_allclose(ik_branches.dh_product(self.rows, q), arm.forward_kinematics(q), atol=1e-14)

    @pytest.mark.slow
    def test_brute_force_finds_the_eight_branches_of_an_ur5e(self, arm):
        T = arm.forward_kinematics(np.array([0.3, -1.2, 1.5, -0.7, 0.9, 0.4]))
        assert len(valid_solutions(arm, T)) == 8  # Hawkins 2013: at most eight, all of them here

    def test_what_a_finder_misses_or_makes_up_is_counted(self, arm):
        q = np.array([0.3, -1.2, 1.5, -0.7, 0.9, 0.4])
        T = arm.forward_kinematics(q)
        every = valid_solutions(arm, T)
        wound = every + 2 * PI * np.array([0, 0, 0, 0, 0, -1])
        wound = np.where((wound < arm.lower), every, wound)
        cases = {
            "all": (every, (1, 0, 0, 0)),
            "wound": (wound, (1, 0, 0, 0)),
            "two missing": (every[2:], (0, 2, 0, 0)),
            "one wrong": (np.vstack([every, q + 0.1]), (1, 0, 0, 1)),
            "none": (np.empty((0, 6)), (0, 8, 0, 0)),
        }
        for name, (found, expected) in cases.items():
            outcome = ik_branches.compare(arm, self.rows, lambda _, f=found: f, lambda _: every, T[None])
            assert (outcome.complete, outcome.missed, outcome.unknown_to_oracle, outcome.wrong) == expected, name
        less = ik_branches.compare(arm, self.rows, lambda _: every, lambda _: every[:7], T[None])
        assert less.unknown_to_oracle == 1

    def test_a_configuration_and_its_turns_are_one_branch(self):
        q = np.array([PI - 1e-5, 0, 0, 0, 0, 0])
        assert ik_branches.apart(q, q + 2 * PI * np.array([1, -1, 0, 0, 0, 2])) == pytest.approx(0, abs=1e-12)
        assert ik_branches.apart(q, q + np.eye(6)[0] * 2e-5) == pytest.approx(2e-5)
        assert len(ik_branches.distinct([q, q + 2 * PI, q + 0.1])) == 2


def test_the_command_measures_and_writes_both_files(tmp_path, monkeypatch, capsys):
    from benchmarks import __main__ as command

    monkeypatch.setattr(command, "PEERS", {"pin": "pinocchio", "frankik": "frankik"})
    monkeypatch.setattr(command, "_options", lambda: SimpleNamespace(robot=["ur5"], n=10, out=tmp_path, peers_only=True))
    command.main()
    (page,) = tmp_path.glob("*.md")
    assert "| ur5 | reachable | ulna | 10 | 100 | 0 |" in page.read_text()
    assert "| ur5 | frankik | " in page.read_text()
    assert page.with_suffix(".json").exists()
    assert page.read_text() in capsys.readouterr().out
