"""Compares kinematics with Pinocchio (pin)."""

import numpy as np
import pinocchio as pin

FRAMES = {
    "base": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    "link": pin.ReferenceFrame.LOCAL,
    "spatial": pin.ReferenceFrame.WORLD,
}


class Peer:
    """A Pinocchio model that takes q, and gives columns, as Ulna orders them, by the names of the joints.

    Made with ``mimic=True`` it has, as Ulna, no entry for a joint that mimics another. Made without, every joint of the file has
    its own entry, and the peer makes mimics follow their leaders itself. A continuous joint is (cos, sin) in Pinocchio's q.

    Links that it lacks are an error, but those named in ``without``.
    """

    def __init__(self, robot, model, without=()) -> None:
        self.model, self.data, self.robot = model, model.createData(), robot
        self.mimics = {joint.name: joint.mimic for joint in robot.description.joints if joint.mimic is not None}
        self.slices = dict(zip(robot.joint_names, robot.joint_slices, strict=True))
        joints = zip(list(model.joints)[1:], list(model.names)[1:], strict=True)
        self.joints = [(joint, name) for joint, name in joints if joint.shortname() != "JointModelMimic"]
        self.shared = [k for k, link in enumerate(robot.link_names) if link not in without]
        self.frames = [self.frame(robot.link_names[k]) for k in self.shared]

    def position(self, name: str, q: np.ndarray) -> np.ndarray:
        if name in self.slices:
            return q[self.slices[name]]
        mimic = self.mimics[name]
        return mimic.multiplier * self.position(mimic.joint, q) + mimic.offset

    def configuration(self, q: np.ndarray) -> np.ndarray:
        entries = np.empty(self.model.nq)
        for joint, name in self.joints:
            value = self.position(name, q)
            if joint.nq == 7:
                value = np.concatenate([value[:3], pin.Quaternion(pin.rpy.rpyToMatrix(*value[3:])).coeffs()])
            elif joint.nq > joint.nv:
                value = [*value[:-1], np.cos(value[-1]), np.sin(value[-1])]
            entries[joint.idx_q : joint.idx_q + joint.nq] = value
        return entries

    def rates(self) -> np.ndarray:
        """d(velocity of every joint) / d(rate of q), for joints of one degree of freedom: shape (nv, n_dof)."""
        zero = np.zeros(self.robot.n_dof)
        matrix = np.zeros((self.model.nv, self.robot.n_dof))
        for column, unit in enumerate(np.eye(self.robot.n_dof)):
            for joint, name in self.joints:
                matrix[joint.idx_v, column] = (self.position(name, unit) - self.position(name, zero))[0]
        return matrix

    def frame(self, link: str) -> int:
        index = self.model.getFrameId(link, pin.FrameType.BODY)
        assert index < self.model.nframes, f"Pinocchio has no link {link!r}"
        return index

    def link_poses(self, q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return np.array([self.data.oMf[frame].homogeneous for frame in self.frames])

    def link_pose(self, q: np.ndarray, link: str) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return self.data.oMf[self.frame(link)].homogeneous

    def jacobian(self, q: np.ndarray, link: str, expressed_in: str) -> np.ndarray:
        return pin.computeFrameJacobian(self.model, self.data, self.configuration(q), self.frame(link), FRAMES[expressed_in])

    def jacobians(self, q: np.ndarray, links) -> dict[str, np.ndarray]:
        """For each of the three frames the Jacobians of some links, shape (n_links, 6, nv)."""
        if self.model.nv == 0:  # Pinocchio ends the process when asked for these
            return {name: np.zeros((len(links), 6, 0)) for name in FRAMES}
        pin.computeJointJacobians(self.model, self.data, self.configuration(q))
        pin.updateFramePlacements(self.model, self.data)
        indices = [self.frame(link) for link in links]
        return {
            name: np.array([pin.getFrameJacobian(self.model, self.data, index, frame).reshape(6, -1) for index in indices])
            for name, frame in FRAMES.items()
        }


def farthest_link(peer: Peer, n: int = 100) -> float:
    """The largest difference in any entry of the pose of any link, over n random configurations."""
    q = random_positions(peer.robot, n)
    return np.abs(peer.robot.link_poses(q)[:, peer.shared] - [peer.link_poses(row) for row in q]).max(initial=0.0)


def farthest_jacobian(peer: Peer, n: int = 100) -> float:
    """The largest difference in any entry of the Jacobian of any tip in any frame, over n random configurations."""
    robot, rates, leaves = peer.robot, peer.rates(), peer.robot.tree.leaves
    q = random_positions(robot, n)
    expected, largest = [peer.jacobians(row, leaves) for row in q], 0.0
    for frame in FRAMES:
        theirs = np.array([jacobians[frame] for jacobians in expected]) @ rates
        for k, link in enumerate(leaves):
            ours = robot.jacobian(q, link=link, expressed_in=frame)
            largest = max(largest, np.abs(ours - theirs[:, k]).max(initial=0.0))
    return largest


def random_positions(robot, n: int, seed: int = 1) -> np.ndarray:
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (n, robot.n_dof))
