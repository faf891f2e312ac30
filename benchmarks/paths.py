"""``python -m benchmarks.paths``: measures ``robot.follow`` on the tracking paths, for the table of docs/performance_ik.md.

The poses come from a smooth joint path, so a continuous path exists. Results are judged by forward kinematics, limits and
differences alone.
"""

import sys
import time

import numpy as np

from ulna.bench.arms import NAMES, load_arm, path_positions
from ulna.bench.protocol import PROTOCOLS, STEP_BOUND, pose_errors, within_limits

POSES = 10_000


def main() -> None:
    """Print a row of the table for each arm."""
    print("| arm | proof | path's largest step | from its beginning | | from anywhere | |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for name in sys.argv[1:] or NAMES:
        robot = load_arm(name)
        path = path_positions(robot, POSES, seed=1)
        T = robot.forward_kinematics(path)
        proof, cells = "", []
        for start in (path[0], None):
            begin = time.perf_counter()
            found = robot.follow(T, start)
            seconds = time.perf_counter() - begin
            proof = str(found.proof)
            cells += [verdict(robot, found, T), f"{seconds:.1f} s"]
        known = np.abs(np.diff(path, axis=0)).max()
        print(f"| {name} | {proof} | {known:.4f} | {' | '.join(cells)} |", flush=True)


def verdict(robot, found, T) -> str:
    """The largest step, if every pose is reached within limits and step; otherwise the end of the path."""
    if not found.success:
        return f"{found.status} at {found.ends_at}"
    good = PROTOCOLS["reachable"].reached(pose_errors(robot.forward_kinematics(found.q), T)) & within_limits(robot, found.q)
    steps = np.abs(np.diff(found.q, axis=0)).max(axis=1)
    wrong = int(np.count_nonzero(~good) + np.count_nonzero(steps > STEP_BOUND))
    return f"{wrong} wrong" if wrong else f"{steps.max():.4f}"


if __name__ == "__main__":
    main()
