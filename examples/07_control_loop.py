"""A control loop at 1 kHz: at every tick a servo gives the joint positions that keep the hand above a moving crate.

Each command is certified: from it the arm can come to rest without touching the crate or the post. With ``--view`` you drag the
crate on a page, whose address is printed: choose it in the tab Obstacles, and drag it behind the post. Ctrl-C ends the loop.
Python is not a real-time system: the loop says how late it was.
"""

import sys
import threading
import time
from collections import Counter

import numpy as np

import ulna

PERIOD = 1e-3  # s
TURN_S, REST_S = 2.0, 0.5  # s: without a page the crate goes once round a circle, then stands still

robot = ulna.load("panda")
START = ulna.pose(xyz=(0.307, 0.0, 0.3))  # of the crate
T_CRATE_HAND = np.linalg.inv(START) @ robot.forward_kinematics(robot.home)
world = ulna.World()
world.add("crate", ulna.Box(extents=(0.08, 0.08, 0.08)), START)
world.add("post", ulna.Cylinder(0.04, 1.0), ulna.pose(xyz=(0.35, -0.35, 0.5)))
servo = robot.servo(world, acceleration=10.0, rate=1 / PERIOD, posture=robot.home)
seen = Counter()  # how many ticks were of each status


def step():
    """One tick. A real arm would be sent ``command.q``."""
    command = servo.step(pose=world.pose("crate") @ T_CRATE_HAND)
    seen[command.status] += 1
    return command.q


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
        view.q = servo.q


def follow_page(came):
    """Follow the crate that is dragged on a page until Ctrl-C."""
    ended = threading.Event()
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: choose the crate in the tab Obstacles and drag it; Ctrl-C ends", flush=True)
        threading.Thread(target=show, args=(view, ended), daemon=True).start()
        try:
            for _ in ticks(sys.maxsize, came):
                step()
        except KeyboardInterrupt:
            ended.set()


came, least = [], robot.signed_distance(robot.home, world)
servo.warm_up()  # compiles, which takes seconds on a new machine: before the clock starts
servo.start(robot.home)
if "--view" in sys.argv:
    follow_page(came)
else:
    for k in ticks(round((TURN_S + REST_S) / PERIOD), came):
        world.move("crate", on_circle(k))
        q = step()
        least = min(least, robot.signed_distance(q, world)) if k % 10 == 0 else least

if len(came) > 1:
    periods = np.diff(came)
    late = np.count_nonzero(periods > 1.5 * PERIOD)
    print(
        f"{len(came)} ticks: a period of {1e3 * np.median(periods):.3f} ms in the median, {1e3 * periods.max():.3f} ms at worst"
    )
    print(f"{late} came late, by more than half a period" if late else "none came late")
print(", ".join(f"{status}: {n}" for status, n in seen.most_common()))
crate = world.pose("crate")
off = np.linalg.norm((robot.forward_kinematics(servo.q) - crate @ T_CRATE_HAND)[:3, 3])
print(f"the crate is at {crate[:3, 3].round(3)} m, the hand {1e3 * off:.2f} mm from its place above it")
assert (off < 1e-4 and least > 0.01) or "--view" in sys.argv
