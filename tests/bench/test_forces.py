"""The benchmark of dynamics: its judges find what is put in their way, and its peers compute the same thing."""

import numpy as np
import pytest
from benchmarks import forces, torque_motions
from benchmarks.peers.pinocchio_forces import Forces


def test_a_peer_that_computes_something_else_is_not_timed(panda):
    assert forces.check(Forces(panda), panda)[1] == ""
    heavy = panda.with_tool(np.eye(4), name="payload", mass=1e-3)
    peer, why = forces.check(Forces(heavy), panda)
    assert peer is None
    assert "its inverse_dynamics differs by" in why
    for name in forces.CALLS[1:]:
        other = Forces(panda)
        other.calls[name] = Forces(heavy).calls[name]
        assert f"its {name} differs by" in forces.check(other, panda)[1]


def test_many_torques_are_those_of_one_motion_after_the_other(panda):
    peer, motions = Forces(panda), forces.random_motions(panda, 9)
    one_by_one = [peer.calls["inverse_dynamics"](x) for x in zip(*motions, strict=True)]
    np.testing.assert_allclose(peer.torques(*motions), one_by_one, rtol=0, atol=1e-12)


def test_rows_name_what_was_timed(panda, monkeypatch):
    monkeypatch.setattr(forces, "CALLS", ("gravity_torque",))
    rows, why = forces.force_data(panda)
    assert why == ""
    assert [(row["work"], row["library"]) for row in rows] == [
        ("inverse_dynamics", "ulna"),
        ("inverse_dynamics", "pin"),
        ("gravity_torque, 4096 at once", "ulna"),
        ("gravity_torque, 4096 at once", "pin, in a loop"),
    ]
    assert all(row["median_ns"] > 0.0 for row in rows)


def test_samples_beyond_a_limit_are_counted(panda):
    path = [panda.home, panda.home + 0.4]
    motion, peer = panda.trajectory(path, acceleration=15.0), Forces(panda)
    t = np.arange(0.0, motion.duration, torque_motions.PERIOD)
    torque = np.abs(panda.inverse_dynamics(*motion.at(t)[:3]))
    for joint in (1, 3):
        most = np.full(7, 1e3)
        most[joint] = np.median(torque[:, joint])
        beyond, share = torque_motions.judged(motion, peer, most)
        assert beyond == pytest.approx(len(t) / 2, abs=2)
        assert share == pytest.approx(torque[:, joint].max() / most[joint], rel=1e-3)
    assert torque_motions.judged(motion, peer, 1.01 * torque.max(axis=0))[0] == 0


def test_stations_lie_on_the_path_of_the_motion(panda):
    path = panda.home + np.array([[0.0] * 7, [0.5, 0, 0.2, 0, 0, 0, 0], [0.5, 0.4, 0.2, -0.3, 0, 0, 0]])
    motion = panda.trajectory(path, acceleration=15.0, within=0.02)
    (stations,) = torque_motions.stations_of(motion)
    assert (np.diff(stations.s) > 0.0).all()
    np.testing.assert_allclose(stations.q[:: torque_motions.FINER], motion.q, atol=1e-12)
    steps = np.diff(stations.s)[:, None]
    np.testing.assert_allclose(np.diff(stations.q, axis=0), steps * (stations.slopes[:-1] + 0.5 * steps * stations.bends[:-1]))
    np.testing.assert_allclose(np.diff(stations.slopes, axis=0), steps * stations.bends[:-1], atol=1e-12)


def test_figures_of_a_path_are_those_of_its_motion(panda):
    """By a peer that needs half of the time, and with a part of 6 kg that makes the motion slower."""
    heavy = panda.with_tool(np.eye(4), name="payload", mass=6.0)
    path = panda.home + np.array([[0.0] * 7, [1.0, 1.0, 0.2, 1.2, 0, 0, 0]])
    seen = []

    def peer(stations, most, inverse_dynamics):
        seen.append(np.abs(inverse_dynamics(stations.q[0], np.zeros(7), np.zeros(7))).max())
        assert most.torque.tolist() == [87.0] * 4 + [12.0] * 3
        return 0.5

    made = torque_motions.compared(heavy, path, Forces(heavy), peer)
    np.testing.assert_allclose(seen, np.abs(heavy.gravity_torque(path[0])).max())
    assert made.beyond == 0
    assert 0.9 < made.share <= 1.0
    assert made.duration > 1.005 * made.without
    assert made.of_copp == 0.5
    assert np.isnan(torque_motions.compared(heavy, path, Forces(heavy), None).of_copp)
