"""Times motions within limits of jerk along lines: ``python -m benchmarks.jerk``, with ``pip install ruckig``.

Ruckig (Berscheid and Kroeger, RSS 2021) computes time-optimal motions from state to state, here from rest to rest; its waypoints,
which a service on the internet computes, are not called. One joint: the durations are to agree to 1e-9. Several joints on a line:
ruckig synchronises them in phase, where that costs no time. With the same limits for all joints it does, and the durations are to
agree. With other limits the line may take longer than the slowest joint alone, and then what ruckig returns leaves the line.
"""

import argparse
import time

import numpy as np
import ruckig

from ulna.planning.double_s import double_s

N_JOINTS = 7
TOLERANCE = 1e-9


def main() -> None:
    """Print how far the durations differ, over random lines; and the time of a call of each."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.jerk", description=__doc__)
    parser.add_argument("--n", type=int, default=10_000, help="lines")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    one, several, times = [], [], np.zeros(2)
    for _ in range(options.n):
        limits = 10 ** rng.uniform(-2, 3, 3)
        length = 10 ** rng.uniform(-4, 2)
        began = time.thread_time()
        ours = double_s(length, *limits)[0].sum()
        between = time.thread_time()
        theirs = optimal(np.array([length]), *(np.array([limit]) for limit in limits))
        times += between - began, time.thread_time() - between
        one.append(abs(ours - theirs) / max(theirs, 1.0))
        way = rng.normal(size=N_JOINTS)
        shared = np.min(1 / np.abs(way)) * limits  # equal limits of all joints: the longest way decides
        theirs = optimal(way, *(np.full(N_JOINTS, limit) for limit in limits))
        several.append(abs(double_s(1.0, *shared)[0].sum() - theirs) / max(theirs, 1.0))
    for name, differences in (("one joint", one), (f"{N_JOINTS} joints in phase", several)):
        verdict = "agree" if max(differences) <= TOLERANCE else "DIFFER"
        print(f"{name}: durations {verdict} to {max(differences):.1e} of the duration, or of 1 s if that is more")
    print(f"a call: {times[0] / options.n * 1e6:.1f} us; ruckig {times[1] / options.n * 1e6:.1f} us, each from Python")


def optimal(way: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray) -> float:
    """The duration of ruckig's motion over a way from rest to rest [s]."""
    n = len(way)
    asked = ruckig.InputParameter(n)
    asked.synchronization = ruckig.Synchronization.Phase
    asked.current_position, asked.target_position = [0.0] * n, list(way)
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = list(velocity), list(acceleration), list(jerk)
    motion = ruckig.Trajectory(n)
    if ruckig.Ruckig(n).calculate(asked, motion) not in {ruckig.Result.Working, ruckig.Result.Finished}:
        raise AssertionError("ruckig finds no motion")
    return motion.duration


if __name__ == "__main__":
    main()
