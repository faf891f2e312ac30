"""A control loop at 1 kHz: at every tick ``differential_ik`` gives the joint velocities that keep the hand above a moving crate.

With ``--view`` you drag the crate on a page, whose address is printed: choose it in the tab Obstacles. Ctrl-C ends the loop.
Python is not a real-time system: the loop says how late it was.
"""

import sys
import threading
import time

import numpy as np

import ulna

PERIOD = 1e-3  # s
GAIN, FASTEST = 20.0, 0.6  # 1/s; m/s and rad/s
TURN_S, REST_S = 2.0, 0.5  # s: without a page the crate goes once round a circle, then stands still

robot = ulna.load("panda")
forward = robot.compile_forward()
q, T = robot.home.copy(), np.empty((4, 4))
twist, qd = np.empty(6), np.empty(robot.n_dof)
START = ulna.pose(xyz=(0.307, 0.0, 0.3))  # of the crate
T_CRATE_HAND = np.linalg.inv(START) @ robot.forward_kinematics(robot.home)


def step(T_crate):
    """One tick: measure, compute, command. A real arm would be asked for q; this one does at once what it is commanded."""
    forward(q, out=T)
    target = T_crate @ T_CRATE_HAND
    twist[:3] = target[:3, 3] - T[:3, 3]
    turn = np.cross(T[:3, :3].T, target[:3, :3].T)  # of each axis of the hand to that of the target
    twist[3:] = 0.5 * turn.sum(axis=0)  # the axis of the rotation that is left, times the sine of its angle
    np.clip(GAIN * twist, -FASTEST, FASTEST, out=twist)
    robot.differential_ik(q, twist, PERIOD, out=qd)
    q[:] += PERIOD * qd


def ticks(n, came):
    """Sleep until the next tick, n times, and add to ``came`` when it was [s]. A late tick moves those that follow."""
    due = time.perf_counter()
    for k in range(n):
        due = max(due + PERIOD, time.perf_counter())
        time.sleep(max(due - time.perf_counter(), 0.0))
        came.append(time.perf_counter())
        yield k


def on_circle(k):
    """The pose of the crate at a tick: once round a circle of 5 cm."""
    angle = 2 * np.pi * min(k * PERIOD / TURN_S, 1.0)
    return START @ ulna.pose(xyz=(0.0, 0.05 * np.sin(angle), 0.05 - 0.05 * np.cos(angle)))


def show(view, ended):
    """Show the arm thirty times a second, in a thread of its own: drawing must not hold up the loop."""
    while not ended.wait(1 / 30):
        view.q = q


def follow_page(came):
    """Follow the crate that is dragged on a page until Ctrl-C. Returns where it was last."""
    world, ended = ulna.World(), threading.Event()
    world.add("crate", ulna.Box(extents=(0.08, 0.08, 0.08)), START)
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: choose the crate in the tab Obstacles and drag it; Ctrl-C ends", flush=True)
        threading.Thread(target=show, args=(view, ended), daemon=True).start()
        try:
            for _ in ticks(sys.maxsize, came):
                step(world.pose("crate"))
        except KeyboardInterrupt:
            ended.set()
    return world.pose("crate")


came, crate = [], START
step(START)  # compiles, which takes seconds on a new machine: before the clock starts
if "--view" in sys.argv:
    crate = follow_page(came)
else:
    for k in ticks(round((TURN_S + REST_S) / PERIOD), came):
        crate = on_circle(k)
        step(crate)

if len(came) > 1:
    periods = np.diff(came)
    late = np.count_nonzero(periods > 1.5 * PERIOD)
    print(
        f"{len(came)} ticks: a period of {1e3 * np.median(periods):.3f} ms in the median, {1e3 * periods.max():.3f} ms at worst"
    )
    print(f"{late} came late, by more than half a period" if late else "none came late")
off = np.linalg.norm((robot.forward_kinematics(q) - crate @ T_CRATE_HAND)[:3, 3])
print(f"the crate is at {crate[:3, 3].round(3)} m, the hand {1e3 * off:.2f} mm from its place above it")
assert off < 1e-4 or "--view" in sys.argv
