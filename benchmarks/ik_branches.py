"""Checks all solutions of six-joint arms for branches that closed forms find and a finder misses.

``python -m benchmarks.ik_branches`` compares ``robot.all_solutions`` with EAIK and ssik. A branch is a configuration up to whole
turns of its joints. The oracle contains both libraries' branches that reach the target by the DH matrices written out here, and
fit into the limits by whole turns.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.peer import bare_urdf, urdf_file, within_limits_by_turns

Array = NDArray[np.float64]
Finder = Callable[[Array], Array]  # T (4, 4) to configurations (n, 6)

SAME = 1e-3  # rad: branches closer than this in every joint are the same
REACHED = 1e-6  # m and rad, of the DH product at a branch

# Rows of a [m], d [m], alpha [rad], theta_offset [rad], standard convention, and limits [rad]. UR5e: Universal Robots, "DH
# parameters for calculations of kinematics and dynamics", table of the UR5e; +-360 degrees per joint.
UR5E = (
    [
        (0, 0.1625, np.pi / 2, 0), (-0.425, 0, 0, 0), (-0.3922, 0, 0, 0),
        (0, 0.1333, np.pi / 2, 0), (0, 0.0997, -np.pi / 2, 0), (0, 0.0996, 0, 0),
    ],
    np.radians([(-360, 360)] * 6),
)  # fmt: skip
# Puma 560: P. Corke and B. Armstrong-Helouvry, "A search for consensus among model parameters reported for the PUMA 560 robot",
# ICRA 1994; limits as in the model of P. Corke's Robotics Toolbox.
PUMA = (
    [
        (0, 0.6718, np.pi / 2, 0), (0.4318, 0, 0, 0), (0.0203, 0.15005, -np.pi / 2, 0),
        (0, 0.4318, np.pi / 2, 0), (0, 0, -np.pi / 2, 0), (0, 0, 0, 0),
    ],
    np.radians([(-160, 160), (-110, 110), (-135, 135), (-266, 266), (-100, 100), (-266, 266)]),
)  # fmt: skip
ARMS = {"ur5e": UR5E, "puma": PUMA}


@dataclass
class Comparison:
    """The share of the oracle's branches that a finder found, over all targets."""

    targets: int = 0
    complete: int = 0
    known: int = 0
    missed: int = 0
    unknown_to_oracle: int = 0
    wrong: int = 0

    def __str__(self) -> str:
        share = 100 * self.complete / self.targets
        return (
            f"{self.complete} of {self.targets} targets complete ({share:.2f} %); of {self.known} branches {self.missed} missed; "
            f"{self.unknown_to_oracle} found that the oracle lacks; {self.wrong} that reach another pose or break a limit"
        )


def compare(robot: ulna.Robot, rows, find: Finder, oracle: Finder, targets: Array) -> Comparison:
    """Compare a finder with the oracle on targets of shape (n, 4, 4)."""
    total = Comparison()
    for T in targets:
        known, found = oracle(T), np.reshape(find(T), (-1, robot.n_dof))
        inside = np.all((found >= robot.lower) & (found <= robot.upper), axis=1)
        good = inside & np.array([reaches(rows, q, T) for q in found], dtype=bool)
        missed = sum(not near_any(q, found[good]) for q in known)
        total.targets += 1
        total.complete += missed == 0
        total.known += len(known)
        total.missed += missed
        total.unknown_to_oracle += sum(not near_any(q, known) for q in distinct(found[good]))
        total.wrong += int(np.count_nonzero(~good))
    return total


def closed_forms(robot: ulna.Robot, rows) -> Finder:
    """The oracle: the branches of EAIK and of ssik together, verified and within the limits."""
    import ssik  # noqa: PLC0415 -- the rest of this file needs no peers
    from eaik.IK_DH import DhRobot  # noqa: PLC0415

    a, d, alpha, _ = np.transpose(rows)
    by_eaik = DhRobot(alpha, a, d)
    with urdf_file(bare_urdf(robot)) as path:
        by_ssik = ssik.Manipulator.from_urdf(path, base=robot.base, ee=robot.tip)

    def oracle(T: Array) -> Array:
        raw = [*by_eaik.IK(T).Q, *(found.q for found in by_ssik.solve(T, respect_limits=False))]
        turned = (within_limits_by_turns(robot, np.asarray(q)) for q in raw if reaches(rows, q, T))
        return distinct([q for q in turned if q is not None])

    return oracle


def dh_product(rows, q: Array) -> Array:
    """The product of the standard DH matrices: Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    T = np.eye(4)
    for (a, d, alpha, offset), position in zip(rows, q, strict=True):
        ct, st, ca, sa = np.cos(position + offset), np.sin(position + offset), np.cos(alpha), np.sin(alpha)
        T = T @ [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
    return T


def reaches(rows, q: Array, T: Array) -> bool:
    """Whether the DH product at q is T."""
    return bool(np.abs(dh_product(rows, q) - T).max() <= REACHED)


def apart(q: Array, p: Array) -> float:
    """The largest angle between two configurations, apart from whole turns [rad]."""
    return float(np.abs((q - p + np.pi) % (2 * np.pi) - np.pi).max())


def near_any(q: Array, branches) -> bool:
    """Whether a configuration is one of the branches."""
    return any(apart(q, p) < SAME for p in branches)


def distinct(configurations) -> Array:
    """The first configuration of each branch, shape (n, 6)."""
    kept: list[Array] = []
    for q in configurations:
        if not near_any(q, kept):
            kept.append(q)
    return np.reshape(kept, (len(kept), 6))


def _found(robot: ulna.Robot, T: Array) -> Array:
    """The solutions of a target within the limits."""
    found = robot.all_solutions(T)
    return found.q[found.valid]


def run(names, n: int) -> Iterator[tuple[str, Comparison]]:
    """The name and the comparison of each arm on n reachable targets."""
    for name in names:
        rows, limits = ARMS[name]
        robot = ulna.Robot.from_dh(rows, convention="standard", limits=limits, name=name)
        targets = robot.forward_kinematics(np.random.default_rng(1).uniform(robot.lower, robot.upper, (n, 6)))
        yield name, compare(robot, rows, partial(_found, robot), closed_forms(robot, rows), targets)


def main() -> None:
    """Compare, and print a line for each arm."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ik_branches", description=__doc__)
    parser.add_argument("--arm", action="append", choices=tuple(ARMS), help="repeatable; all of them unless given")
    parser.add_argument("--n", type=int, default=500, help="targets of each arm (default 500)")
    options = parser.parse_args()
    for name, outcome in run(options.arm or ARMS, options.n):
        sys.stdout.write(f"{name}: {outcome}\n")


if __name__ == "__main__":
    main()
