"""Defines a peer: another library's computations for the same arm, in the same form, verified before timing."""

import importlib
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from ulna.bench.arms import random_positions
from ulna.bench.protocol import Protocol, Solver
from ulna.description.pose import inverse
from ulna.description.urdf_writer import write_urdf
from ulna.robot import Robot

Array = NDArray[np.float64]

# The name under which each is installed, and the module of ``peers`` that calls it.
PEERS = {
    "pin": "pinocchio",
    "roboticstoolbox-python": "roboticstoolbox",
    "pytracik": "tracik",
    "frankik": "frankik",
    "ssik": "ssik",
    "EAIK": "eaik",
    "mujoco": "mujoco",
    "ikpy": "ikpy",
    "frax": "frax",
    "pytorch-kinematics": "pytorch_kinematics",
}


class NotForThisArm(Exception):  # noqa: N818 -- it is no error
    """The reason why a peer does not support an arm."""


@dataclass(frozen=True)
class Peer:
    """The functions of a library for one arm; None for unsupported ones.

    Attributes:
        forward: Maps the library's own q to the 4x4 matrix of the tip in the base.
        jacobian: Maps its q to the geometric Jacobian, shape (6, n_dof), linear rows first, in the axes of the base.
        solver: Maps a protocol to the solver.
        own_q: Converts Ulna's q, shape (n_dof,), to the library's.
        forward_kept: Like ``forward``, with cached look-ups between calls, as in a control loop.
        forward_batch, jacobian_batch: The same for many q at once, shape (n, n_dof).
    """

    forward: Callable[[Array], Array] | None = None
    jacobian: Callable[[Array], Array] | None = None
    solver: Callable[[Protocol], Solver] | None = None
    own_q: Callable[[Array], Array] = lambda q: q
    forward_kept: Callable[[Array], Array] | None = None
    forward_batch: Callable[[Array], Array] | None = None
    jacobian_batch: Callable[[Array], Array] | None = None


def make_peer(name: str, robot: Robot) -> tuple[Peer | None, str]:
    """The verified peer for an arm; or None, and the reason."""
    try:
        peer = importlib.import_module(f"benchmarks.peers.{PEERS[name]}").make(robot)
    except ImportError as error:
        return None, f"absent: {error}"
    except NotForThisArm as reason:
        return None, str(reason)
    return check(peer, robot)


def check(peer: Peer, robot: Robot, tolerance: float = 1e-7) -> tuple[Peer | None, str]:
    """The peer if it agrees with Ulna at a hundred configurations; otherwise None, and the difference."""
    q = random_positions(robot, 100, seed=3)
    poses, jacobians = robot.forward_kinematics(q), robot.jacobian(q)
    answers = {
        "poses": (_one_by_one(peer, peer.forward, q), poses),
        "kept poses": (_one_by_one(peer, peer.forward_kept, q), poses),
        "Jacobians": (_one_by_one(peer, peer.jacobian, q), jacobians),
        "poses of a batch": (peer.forward_batch and peer.forward_batch(q), poses),
        "Jacobians of a batch": (peer.jacobian_batch and peer.jacobian_batch(q), jacobians),
    }
    for kind, (theirs, ours) in answers.items():
        off = 0.0 if theirs is None else float(np.abs(theirs - ours).max())
        if not off <= tolerance:
            return None, f"its {kind} differ by {off:.1e}"
    return peer, ""


def _one_by_one(peer: Peer, function: Callable[[Array], Array] | None, q: Array) -> Array | None:
    return None if function is None else np.array([function(peer.own_q(x)) for x in q])


def bare_urdf(robot: Robot) -> str:
    """URDF text of the arm's joints and links alone, as the peers read it.

    It has no meshes, and no soft limits, which some peers misread. Every limit has the effort and the velocity that some peers
    require.
    """
    links = tuple(replace(link, visuals=(), collisions=()) for link in robot.description.links)
    text = re.sub(r"<safety_controller\b[^>]*/>", "", write_urdf(replace(robot.description, links=links)))
    for attribute in ("effort", "velocity"):
        text = re.sub(rf"<limit (?![^>]*{attribute}=)", f'<limit {attribute}="1" ', text)
    return text


@contextmanager
def urdf_file(text: str) -> Iterator[str]:
    """The path of a file that holds a URDF, for peers that read nothing else."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(text, encoding="utf-8")
        yield str(path)


def standing_offset(robot: Robot, forward: Callable[[Array], Array]) -> Array:
    """T_tip_peer, the pose of a peer's last frame on Ulna's tip, if it is constant.

    Raises:
        NotForThisArm: It is not constant: the peer's arm has another geometry.
    """
    q = random_positions(robot, 5, seed=2)
    offsets = np.array([inverse(robot.forward_kinematics(x)) @ forward(x) for x in q])
    off = float(np.abs(offsets - offsets[0]).max())
    if off > 1e-8:
        raise NotForThisArm(f"its arm is another: their tips move apart by {off:.1e}")
    return offsets[0]


def within_limits_by_turns(robot: Robot, q: Array) -> Array | None:
    """The configuration with each joint shifted by whole turns into its limits, or None if impossible."""
    lower = np.where(np.isinf(robot.lower), q, robot.lower)
    turned = q + 2 * np.pi * np.ceil((lower - q) / (2 * np.pi) - 1e-9)
    return turned if (turned <= robot.upper + 1e-9).all() else None
