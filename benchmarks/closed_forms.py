"""Measures closed forms: missed branches over random and nearly singular targets, and times next to other libraries.

``python -m benchmarks.closed_forms`` prints the tables for docs/performance_ik.md. A branch counts as missed if the configuration
that made a target is not among the solutions, apart from whole turns. Near a singularity, only its first joint and the joint that
makes it singular are compared. A sample of the targets is also counted by the search from many starts, which knows no closed
form, and by EAIK if installed. Errors are the largest entries of T(q) - T, by forward kinematics.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.closed_form_peers import HEAD, eaik_of, peer_table
from benchmarks.ik_branches import PUMA, UR5E, distinct
from ulna.bench.arms import load_arm
from ulna.ik.closed_form.closed_form import joints_at
from ulna.ik.options import Options
from ulna.ik.problem import Query, make_problem
from ulna.ik.search.branch_search import _branches

Array = NDArray[np.float64]
_CHUNK = 50_000
_OFF = (1e-1, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 0.0)
_REPEATS = 21


def ur(d1: float, a2: float, a3: float, d4: float, d5: float, d6: float) -> list[tuple[float, ...]]:
    """Universal Robots, "DH parameters for calculations of kinematics and dynamics"; standard convention."""
    half = np.pi / 2
    return [(0, d1, half, 0), (a2, 0, 0, 0), (a3, 0, 0, 0), (0, d4, half, 0), (0, d5, -half, 0), (0, d6, 0, 0)]


def wrist(a1: float, d1: float, a2: float, d3: float, a3: float, d4: float, d6: float) -> list[tuple[float, ...]]:
    """An arm with a spherical wrist; standard convention.

    Lengths are those of the makers' data sheets, as these public descriptions repeat them (compared in November 2026):
    ros-industrial/kuka_experimental kr6r700sixx_macro.xacro, ros-industrial/abb irb120_3_58_macro.xacro, petercorke's
    robotics-toolbox-matlab mdl_irb140.m, ros-industrial/fanuc lrmate200id_macro.xacro, ros-industrial/staubli_experimental
    tx60_macro.xacro (its lateral 20 mm are 217.5 - 197.5).
    """
    half = np.pi / 2
    return [(a1, d1, -half, 0), (a2, 0, 0, -half), (a3, d3, -half, 0), (0, d4, half, 0), (0, 0, -half, 0), (0, d6, 0, 0)]


ARMS = {
    "UR3": ur(0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "UR5": ur(0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "UR10": ur(0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "UR5e": UR5E[0],
    "UR10e": ur(0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "Puma 560": PUMA[0],
    "KUKA KR 6 R700": wrist(0.025, 0.4, 0.315, 0.0, 0.035, 0.365, 0.08),
    "ABB IRB 120": wrist(0.0, 0.29, 0.27, 0.0, 0.07, 0.302, 0.072),
    "ABB IRB 140": wrist(0.07, 0.352, 0.36, 0.0, 0.0, 0.38, 0.065),
    "Fanuc LR Mate 200iD": wrist(0.05, 0.33, 0.33, 0.0, 0.035, 0.335, 0.08),
    "Staeubli TX60": wrist(0.0, 0.375, 0.29, 0.02, 0.0, 0.31, 0.07),
}
FILES = {"Z1": "z1", "Jaco2": "jaco2"}  # the wrist of neither is singular within its limits


def arms() -> Iterator[tuple[str, ulna.Robot]]:
    """Name and robot; a robot from a table may turn each joint by half a turn either way."""
    for name, rows in ARMS.items():
        yield name, ulna.Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 6, name=name)
    for name, file in FILES.items():
        yield name, load_arm(file)


def apart(a: Array, b: Array) -> Array:
    """The largest difference, apart from whole turns."""
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)


def missed(robot: ulna.Robot, q: Array, columns: list[int], near: float) -> tuple[int, float]:
    """The number of configurations (n, 6) not found again, by some joints, and all solutions' largest error."""
    lacking, worst = 0, 0.0
    for begin in range(0, len(q), _CHUNK):
        part = q[begin : begin + _CHUNK]
        T = robot.forward_kinematics(part)
        found = robot.all_solutions(T)
        away = np.where(found.real, apart(np.nan_to_num(found.q)[..., columns], part[:, None, columns]), 9.0)
        lacking += int((away.min(axis=1) > near).sum())
        reached = robot.forward_kinematics(found.q[found.real])
        worst = max(worst, float(np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max()))
    return lacking, worst


def searched(robot: ulna.Robot, targets: Array) -> int:
    """The number of branches within the limits that only a search from many starts finds."""
    query = Query(
        robot.tree,
        robot.home,
        robot._checker,  # noqa: SLF001
        robot.tip or "",
        Options(position_tolerance=1e-9, rotation_tolerance=1e-9),
    )
    lacking = 0
    for T in targets:
        solutions = robot.all_solutions(T)
        known = solutions.q[solutions.real]
        lacking += sum(not (apart(known, q) < 1e-3).any() for q in _branches(make_problem(query, T, None), 16))
    return lacking


def of_eaik(robot: ulna.Robot, targets: Array) -> tuple[int, int]:
    """The number of valid branches that only EAIK returns, and of those that only the closed form returns."""
    peer, lacking, lacked = eaik_of(robot), 0, 0
    for T in targets if peer is not None else ():
        own = robot.all_solutions(T)
        theirs = np.atleast_2d(peer.calculate_IK(T).Q).reshape(-1, 6)
        theirs = theirs[np.abs(robot.forward_kinematics(theirs) - T).max(axis=(1, 2)) < 1e-7]
        known = distinct(list(own.q[own.real]))
        lacking += sum(not (apart(known, q) < 1e-3).any() for q in theirs)
        lacked += sum(not len(theirs) or not (apart(theirs, q) < 1e-3).any() for q in known)
    return lacking, lacked


def branches_table(n: int, n_searched: int) -> Iterator[str]:
    """A row for each arm."""
    yield (
        "| arm | random targets | not found | largest error | nearly singular targets | not found | largest error | "
        "branches found only by search, by EAIK |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for name, robot in arms():
        rng = np.random.default_rng(1)
        low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
        q = rng.uniform(low, high, (n, 6))
        lacking, worst = missed(robot, q, list(range(6)), 1e-4)
        near = rng.uniform(low, high, (n // 10 if name in ARMS else 0, 6))
        near[:, 4] = np.resize(_OFF, len(near))  # the wrist is singular at 0
        lacking_near, worst_near = missed(robot, near, [0, 4], 1e-4)
        T = robot.forward_kinematics(q[:n_searched])
        more, by_eaik = searched(robot, T), of_eaik(robot, robot.forward_kinematics(q[:2000]))
        yield (
            f"| {name} | {n:,} | {lacking} | {worst:.0e} | {len(near):,} | {lacking_near} | {worst_near:.0e} | "
            f"{more} of {n_searched} targets, {by_eaik[0]} of 2,000 (EAIK lacks {by_eaik[1]}) |"
        )


def nanoseconds(work: Callable[[], object], n: int) -> float:
    """CPU time of the process for each of n targets."""
    begin = time.process_time_ns()
    work()
    return (time.process_time_ns() - begin) / n


def speed_table() -> Iterator[str]:
    """A row for each of two families: medians of interleaved turns.

    In each turn a work is done twice. The times are those of the second run, with its data in the cache; the ratio in brackets
    belongs to the first run, after the other work has used the cache.
    """
    yield (
        "| arm | branches, batch | EAIK, batch | EAIK / branches, batch | `all_solutions`, batch | "
        "EAIK / `all_solutions`, batch | `all_solutions`, one call | EAIK, one call | "
        "EAIK / `all_solutions`, one call | `inverse_kinematics`, batch | `inverse_kinematics`, one call |"
    )
    yield "|" + "---|" * 11
    for name, robot in arms():
        peer = eaik_of(robot)
        if name not in {"UR5", "Puma 560"} or peer is None:
            continue
        T = robot.forward_kinematics(np.random.default_rng(2).uniform(-np.pi, np.pi, (2048, 6)))
        form, home = joints_at(robot.closed_form, np.zeros(6)), np.zeros((1, 6))
        some, every = [T[i] for i in range(256)], [T[i] for i in range(2048)]
        works = [
            (lambda form=form, T=T, home=home: form.branches(T, home), 2048),
            (lambda peer=peer, every=every: peer.calculate_IK_batched(every, 1), 2048),
            (lambda robot=robot, T=T: robot.all_solutions(T), 2048),
            (lambda robot=robot, some=some: [robot.all_solutions(x) for x in some], 256),
            (lambda peer=peer, some=some: [peer.calculate_IK(x) for x in some], 256),
            (lambda robot=robot, T=T: robot.inverse_kinematics(T), 2048),
            (lambda robot=robot, some=some: [robot.inverse_kinematics(x) for x in some], 256),
        ]
        with ulna.threads(1):
            for work, _ in works:  # compiles and fills caches
                work()
            times = np.array([[(nanoseconds(*work), nanoseconds(*work)) for work in works] for _ in range(_REPEATS)])
        many, public, one = (times_of(times, theirs, own) for theirs, own in ((1, 0), (1, 2), (4, 3)))
        kernel, batch, of_many, of_one, peer_one, *others = (f"{x:,.0f} ns" for x in np.median(times[:, :, 1], axis=0))
        yield (
            f"| {name} | {kernel} | {batch} | {many} | {of_many} | {public} | {of_one} | {peer_one} | {one} | "
            f"{' | '.join(others)} |"
        )


def times_of(times: Array, theirs: int, own: int) -> str:
    """The ratio of two works, each after itself and, in brackets, after the other."""
    first, again = np.median(times[:, theirs] / times[:, own], axis=0)
    return f"{again:.1f} ({first:.1f})"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.closed_forms", description=__doc__)
    parser.add_argument("--n", type=int, default=1_000_000, help="random targets of each arm (default 1,000,000); 0: times alone")
    parser.add_argument("--searched", type=int, default=100, help="targets of each arm that are searched too (default 100)")
    options = parser.parse_args()
    for row in speed_table():
        sys.stdout.write(row + "\n")
    sys.stdout.write(HEAD)
    for name, robot in arms():
        if name in {"UR5", "UR5e", "Puma 560"}:
            for row in peer_table(robot, name):
                sys.stdout.write(row + "\n")
                sys.stdout.flush()
    if options.n == 0:
        return
    for row in branches_table(options.n, options.searched):
        sys.stdout.write(row + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
