"""Targets, judged by Pinocchio and by the arms' own limits."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from ulna.bench.arms import ARMS, NAMES, load_arm, longest_reach, middle, out_of_reach, path_positions, random_positions
from ulna.errors import UlnaError

INSTALLED = [name for name in NAMES if name != "iiwa14"]  # its data package is no dependency of the tests
# Two slides, one of which goes both ways, and a link beyond them: its reach can be worked out in the head.
SLIDES = """<robot name="slides"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="x" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/><limit lower="-2" upper="1"/></joint>
  <joint name="y" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5"/></joint>
  <joint name="e" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0 0 0.25"/></joint></robot>"""


@pytest.mark.parametrize("name", INSTALLED)
def test_every_arm_of_the_table_is_one_chain(name):
    arm = load_arm(name)
    assert arm.tip == (ARMS[name].tip if name in ARMS else "panda_ee")
    assert arm.n_dof == {"ur5": 6, "ur10": 6, "jaco2": 6, "z1": 6, "so100": 5, "so101": 5}.get(name, 7)


def test_an_arm_whose_file_is_not_installed_says_what_to_install(monkeypatch):
    monkeypatch.setattr("sys.path", [])
    with pytest.raises(UlnaError, match="iiwa14: its description is not installed; pip install rtb-data"):
        load_arm("iiwa14")


@pytest.mark.parametrize("name", ["panda", "jaco2", "so101"])
def test_random_positions_and_paths_keep_the_limits(name):
    arm = load_arm(name)
    for q in (random_positions(arm, 500, 0), path_positions(arm, 500, 0)):
        assert q.shape == (500, arm.n_dof)
        assert ((q >= arm.lower) & (q <= arm.upper)).all()
    bounded = np.isfinite(arm.upper - arm.lower)
    np.testing.assert_allclose(middle(arm)[bounded], (arm.lower[bounded] + arm.upper[bounded]) / 2)
    np.testing.assert_allclose(middle(arm)[~bounded], 0.0, atol=1e-15)


def test_limits_that_are_as_good_as_none_give_positions_that_can_be_reached():
    arm = ulna.Robot.from_dh([(0.1, 0, 0.3, 0)] * 3, limits=[(-1e16, 1e16), (-1, 2), (-1e16, 1e16)])
    for q in (random_positions(arm, 50, 0), path_positions(arm, 50, 0)):
        assert (np.abs(q) <= np.pi).all()
    assert np.isfinite(out_of_reach(arm, 50, 0)).all()


def test_a_path_is_smooth():
    steps = np.diff(path_positions(load_arm("panda"), 10_000, 0), axis=0)
    assert 0 < np.abs(steps).max() < 0.01
    assert np.abs(np.diff(steps, axis=0)).max() < 1e-4


def test_the_same_seed_gives_the_same_targets(panda):
    np.testing.assert_array_equal(random_positions(panda, 5, 1), random_positions(panda, 5, 1))
    assert not np.array_equal(random_positions(panda, 5, 1), random_positions(panda, 5, 2))


@pytest.mark.parametrize("name", ["panda", "ur5", "jaco2"])
def test_no_configuration_reaches_beyond_the_longest_reach(name):
    arm = load_arm(name)
    model = pin.buildModelFromXML(arm.to_urdf())
    data = model.createData()
    furthest = 0.0
    for _ in range(300):
        pin.framesForwardKinematics(model, data, pin.randomConfiguration(model, np.full(model.nq, -3.0), np.full(model.nq, 3.0)))
        furthest = max(furthest, float(np.linalg.norm(data.oMf[model.getFrameId(arm.tip)].translation)))
    assert furthest < longest_reach(arm)


def test_slides_count_to_the_reach_with_their_further_end():
    assert longest_reach(ulna.load(SLIDES)) == pytest.approx(2 + 0.5 + 0.25)


def test_what_is_out_of_reach_is_a_pose_beyond_the_reach(panda):
    T = out_of_reach(panda, 50, 0)
    assert (np.linalg.norm(T[:, :3, 3], axis=1) >= 1.0099 * longest_reach(panda)).all()
    np.testing.assert_allclose(T[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-12)
