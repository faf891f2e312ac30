"""Measures dynamics next to Pinocchio, single calls and batches, and motions within torque limits next to copp-py.

``python -m benchmarks.forces`` times the calls, ``python -m benchmarks.forces RESOURCES/panda`` the motions too: see
``benchmarks.plans`` for the folder. Everything runs in one thread.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.kinematics import BATCH, LOOP, ONE, rows_of, short
from benchmarks.markdown import table
from benchmarks.peer import NotForThisArm
from ulna.bench.arms import random_positions
from ulna.bench.timing import Workload, time_interleaved

Array = NDArray[np.float64]
CALLS = "inverse_dynamics", "gravity_torque", "mass_matrix", "forward_dynamics", "inverse_dynamics_derivatives"
AGAIN = 8  # maximum calls of a batch per pass; the first call does not find its data in the caches
SAME = 1e-9  # of the largest number: a peer with larger differences computes another quantity


class Motions(NamedTuple):
    """Random motions; the accelerations serve as torques for forward dynamics."""

    q: Array
    qd: Array
    qdd: Array

    def of(self, name: str) -> tuple[Array, ...]:
        """The arguments of a call."""
        return self[:1] if name in {"gravity_torque", "mass_matrix"} else tuple(self)


def random_motions(robot: ulna.Robot, n: int) -> Motions:
    """Motions of random q within the limits, with normally distributed rates."""
    return Motions(random_positions(robot, n, seed=0), *np.random.default_rng(1).normal(size=(2, n, robot.n_dof)))


def force_data(robot: ulna.Robot) -> tuple[list[dict], str]:
    """The rows of all calls, and the reason for Pinocchio's absence, if so."""
    try:
        from benchmarks.peers.pinocchio_forces import Forces  # noqa: PLC0415 -- it may be absent

        peer, why = check(Forces(robot), robot)
    except ImportError as error:
        peer, why = None, f"absent: {error}"
    except NotForThisArm as reason:
        peer, why = None, str(reason)
    with ulna.threads(1):
        one = single_rows(robot, peer)
        return one + [row for name in CALLS for row in batch_rows(robot, peer, name)], why


def check(peer, robot: ulna.Robot):
    """The peer if it agrees with Ulna for twenty motions; otherwise None, and the largest difference."""
    motions = random_motions(robot, 20)
    for name in CALLS:
        ours = np.stack(np.atleast_1d(getattr(robot, name)(*motions.of(name))))
        ours = ours if name == "inverse_dynamics_derivatives" else ours[None]
        for k, x in enumerate(zip(*motions, strict=True)):
            theirs = peer.calls[name](x)
            theirs = np.stack(theirs[:2]) if isinstance(theirs, tuple) else np.asarray(theirs)[None]
            if name == "mass_matrix":
                theirs = np.triu(theirs) + np.swapaxes(np.triu(theirs, 1), 1, 2)  # it writes the upper triangle
            off = np.abs(theirs - ours[:, k]).max() / max(1.0, np.abs(ours).max())
            if not off <= SAME:
                return None, f"its {name} differs by {off:.1e}"
    return peer, ""


def single_rows(robot: ulna.Robot, peer) -> list[dict]:
    """One inverse dynamics for one motion."""
    inputs = list(zip(*random_motions(robot, ONE), strict=True))
    works = {"ulna": Workload(lambda x: robot.inverse_dynamics(*x), inputs)}
    if peer is not None:
        works["pin"] = Workload(peer.calls["inverse_dynamics"], inputs)
    return rows_of("panda", "inverse_dynamics", time_interleaved(works, passes=81))


def batch_rows(robot: ulna.Robot, peer, name: str) -> list[dict]:
    """A batch: Ulna in one call, Pinocchio in a Python loop (part of the batch) or in one call."""
    motions = random_motions(robot, BATCH)
    ours = _ours(robot, name)
    works = {"ulna": Workload(ours, short(ours, [motions.of(name)] * AGAIN), BATCH)}
    if peer is not None:
        call, some = peer.calls[name], [tuple(each[k] for each in motions) for k in range(LOOP)]
        some = short(call, some)
        works["pin, in a loop"] = Workload(lambda batch: [call(x) for x in batch], [some], len(some))
        if name in peer.batches:
            columns = [np.asfortranarray(each.T) for each in motions]
            works["pin, at once"] = Workload(peer.batches[name], short(peer.batches[name], [columns] * AGAIN), BATCH)
    return rows_of("panda", f"{name}, {BATCH} at once", time_interleaved(works, passes=41))


def _ours(robot: ulna.Robot, name: str) -> Callable:
    """The call of a batch, which writes to an existing array."""
    call, n = getattr(robot, name), robot.n_dof
    shapes = {"mass_matrix": (BATCH, n, n), "inverse_dynamics_derivatives": (2, BATCH, n, n)}
    out = np.empty(shapes.get(name, (BATCH, n)))
    return lambda x: call(*x, out=out)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.forces", description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="of VAMP's Panda, for the motions")
    parser.add_argument("--every", type=int, default=1, help="one problem of so many")
    options = parser.parse_args()
    robot = ulna.load("panda")
    rows, why = force_data(robot)
    sys.stdout.write(table(rows) + "\n" + (f"pin: {why}\n" if why else ""))
    if options.folder is not None:
        from benchmarks.torque_motions import motion_rows  # noqa: PLC0415 - it needs Pinocchio

        sys.stdout.write("\n" + table(motion_rows(robot, options.folder, options.every)) + "\n")


if __name__ == "__main__":
    main()
