"""Forward kinematics and Jacobians against Pinocchio (pin), on the Panda and on the arms of example-robot-data.

Pinocchio is built without mimic joints: there every joint of the file has its own entry, and the test itself makes a mimic
follow its leader, so that the ratio and offset are checked too. A continuous joint is (cos, sin) in Pinocchio's q.
"""

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import ulna

SHARE = Path("cmeel.prefix") / "share" / "example-robot-data" / "robots"
ROBOTS = next(Path(entry) / SHARE for entry in sys.path if (Path(entry) / SHARE).is_dir())
FRAMES = {
    "base": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    "link": pin.ReferenceFrame.LOCAL,
    "spatial": pin.ReferenceFrame.WORLD,
}
ARMS = {
    "panda_description/urdf/panda.urdf": 8,  # with fingers, of which one mimics the other
    "ur_description/urdf/ur3_robot.urdf": 6,
    "ur_description/urdf/ur5_robot.urdf": 6,
    "ur_description/urdf/ur5_gripper.urdf": 6,
    "ur_description/urdf/ur10_robot.urdf": 6,
    "kinova_description/robots/kinova.urdf": 6,  # continuous joints
    "z1_description/urdf/z1.urdf": 7,
    "xarm_description/urdf/xarm7.urdf": 7,
    "so_arm_description/urdf/so101.urdf": 6,
    "talos_data/robots/talos_left_arm.urdf": 7,
    "baxter_description/urdf/baxter.urdf": 17,
    "tiago_description/robots/tiago.urdf": 48,  # wheels, prismatic torso, a hand
    "pr2_description/urdf/pr2.urdf": 20,
    "allegro_hand_description/urdf/allegro_left_hand.urdf": 16,
    "alex_description/urdf/alex_sake_hands.urdf": 23,
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf": 43,
}
PLANAR_AND_FLOATING = """<robot name="raft">
  <link name="sea"/><link name="raft"/><link name="bird"/><link name="beak"/>
  <joint name="drift" type="planar">
    <parent link="sea"/><child link="raft"/><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="flight" type="floating"><parent link="raft"/><child link="bird"/><origin xyz="0 0.5 0" rpy="0.1 -0.2 1.3"/></joint>
  <joint name="nod" type="continuous">
    <parent link="bird"/><child link="beak"/><origin xyz="0.2 0 0"/><axis xyz="1 2 -2"/>
  </joint>
</robot>"""


class Peer:
    """A Pinocchio model that takes q as Ulna orders it, by the names of the joints."""

    def __init__(self, robot, model) -> None:
        self.model, self.data, self.robot = model, model.createData(), robot
        self.mimics = {joint.name: joint.mimic for joint in robot.description.joints if joint.mimic is not None}

    def position(self, name: str, q: np.ndarray) -> np.ndarray:
        if name in self.robot.joint_names:
            return q[self.robot.joint_slices[self.robot.joint_names.index(name)]]
        mimic = self.mimics[name]
        return mimic.multiplier * self.position(mimic.joint, q) + mimic.offset

    def configuration(self, q: np.ndarray) -> np.ndarray:
        entries = np.empty(self.model.nq)
        for joint, name in zip(self.model.joints[1:], list(self.model.names)[1:], strict=True):
            value = self.position(name, q)
            if joint.nq == 7:
                value = np.concatenate([value[:3], pin.Quaternion(pin.rpy.rpyToMatrix(*value[3:])).coeffs()])
            elif joint.nq > joint.nv:
                value = [*value[:-1], np.cos(value[-1]), np.sin(value[-1])]
            entries[joint.idx_q : joint.idx_q + joint.nq] = value
        return entries

    def rates(self) -> np.ndarray:
        """d(velocity of every joint) / d(rate of q), for joints of one degree of freedom."""
        zero = np.zeros(self.robot.n_dof)
        columns = []
        for unit in np.eye(self.robot.n_dof):
            column = np.empty(self.model.nv)
            for joint, name in zip(self.model.joints[1:], list(self.model.names)[1:], strict=True):
                column[joint.idx_v] = (self.position(name, unit) - self.position(name, zero))[0]
            columns.append(column)
        return np.array(columns).T

    def frame(self, link: str) -> int:
        index = self.model.getFrameId(link, pin.FrameType.BODY)
        assert index < self.model.nframes, f"Pinocchio has no link {link!r}"
        return index

    def link_poses(self, q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return np.array([self.data.oMf[self.frame(link)].homogeneous for link in self.robot.link_names])

    def jacobian(self, q: np.ndarray, link: str, expressed_in: str) -> np.ndarray:
        return pin.computeFrameJacobian(self.model, self.data, self.configuration(q), self.frame(link), FRAMES[expressed_in])


def random_positions(robot, n: int) -> np.ndarray:
    lower, upper = np.maximum(robot.lower, -4.0), np.minimum(robot.upper, 4.0)
    return np.random.default_rng(1).uniform(lower, upper, (n, robot.n_dof))


@pytest.fixture(scope="module")
def panda_peer(panda):
    return Peer(panda, pin.buildModelFromXML(panda.to_urdf()))


def test_the_panda_stands_where_pinocchio_puts_it_in_every_link(panda, panda_peer):
    q = np.vstack([panda.home, np.zeros(7), panda.lower, panda.upper, random_positions(panda, 100)])
    expected = np.array([panda_peer.link_poses(row) for row in q])
    np.testing.assert_allclose(panda.link_poses(q), expected, rtol=0, atol=1e-12)
    one_by_one = np.array([panda.link_poses(row) for row in q])
    np.testing.assert_allclose(one_by_one, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("expressed_in", FRAMES)
@pytest.mark.parametrize("link", ["panda_link1", "panda_link4", "panda_link8", "panda_ee"])
def test_a_jacobian_of_the_panda_is_pinocchios_in_each_of_its_frames(panda, panda_peer, link, expressed_in):
    q = np.vstack([panda.home, np.zeros(7), random_positions(panda, 100)])
    expected = np.array([panda_peer.jacobian(row, link, expressed_in) for row in q])
    np.testing.assert_allclose(panda.jacobian(q, link=link, expressed_in=expressed_in), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(panda.jacobian(q[3], link=link, expressed_in=expressed_in), expected[3], rtol=0, atol=1e-12)


def test_the_three_frames_of_a_jacobian_are_three_different_things(panda):
    J = [panda.jacobian(panda.home, expressed_in=name) for name in FRAMES]
    assert min(np.abs(J[i] - J[k]).max() for i, k in ((0, 1), (0, 2), (1, 2))) > 0.1


@pytest.fixture(scope="module", params=ARMS, ids=lambda path: Path(path).stem)
def arm(request):
    robot = ulna.load(ROBOTS / request.param)
    assert robot.n_dof == ARMS[request.param]
    return Peer(robot, pin.buildModelFromUrdf(str(ROBOTS / request.param)))


def test_every_link_of_an_arm_stands_where_pinocchio_puts_it(arm):
    q = random_positions(arm.robot, 20)
    np.testing.assert_allclose(arm.robot.link_poses(q), np.array([arm.link_poses(row) for row in q]), rtol=0, atol=1e-9)


def test_every_leaf_of_an_arm_moves_as_pinocchio_says_mimics_included(arm):
    q, rates = random_positions(arm.robot, 1)[0], arm.rates()
    for link in arm.robot.tree.leaves:
        expected = arm.jacobian(q, link, "base") @ rates
        np.testing.assert_allclose(arm.robot.jacobian(q, link=link), expected, rtol=0, atol=1e-9, err_msg=link)


def test_planar_and_floating_joints_stand_where_pinocchio_puts_them():
    robot = ulna.load(PLANAR_AND_FLOATING)
    peer = Peer(robot, pin.buildModelFromXML(PLANAR_AND_FLOATING))
    assert robot.joint_slices == (slice(0, 3), slice(3, 9), slice(9, 10))
    for q in random_positions(robot, 50):
        np.testing.assert_allclose(robot.link_poses(q), peer.link_poses(q), rtol=0, atol=1e-12)
