"""Runs a control loop at 1 kHz: a servo commands joint positions that keep the hand above a moving crate.

Each command is certified: from it the arm can stop without touching the crate or the post. With ``--view`` you drag the crate on
a page, whose address is printed: choose the crate in the tab Obstacles, and drag it behind the post. Ctrl-C ends the loop. Python
is not a real-time system; the loop prints how late its ticks were.
"""

import sys
import threading
import time
from collections import Counter

import numpy as np

import ulna

PERIOD = 1e-3  # s
TURN_S, REST_S = 2.0, 0.5  # s: without a page the crate moves once around a circle, then stands still

robot = ulna.load("panda")
START = ulna.pose(xyz=(0.307, 0.0, 0.3))  # of the crate
T_CRATE_HAND = np.linalg.inv(START) @ robot.forward_kinematics(robot.home)
world = ulna.World()
world.add("crate", ulna.Box(extents=(0.08, 0.08, 0.08)), START)
world.add("post", ulna.Cylinder(0.04, 1.0), ulna.pose(xyz=(0.35, -0.35, 0.5)))
servo = robot.servo(world, acceleration=10.0, rate=1 / PERIOD, posture=robot.home)
status_counts = Counter()  # the number of ticks with each status


def step():
    """Make one tick. Send ``command.q`` to a real arm here."""
    command = servo.step(pose=world.pose("crate") @ T_CRATE_HAND)
    status_counts[command.status] += 1
    return command.q


def ticks(n, tick_times):
    """Sleep until the next tick, n times, and add its time to ``tick_times`` [s]. A late tick delays all others."""
    due = time.perf_counter()
    for k in range(n):
        due = max(due + PERIOD, time.perf_counter())
        time.sleep(max(due - time.perf_counter(), 0.0))
        tick_times.append(time.perf_counter())
        yield k


def on_circle(k):
    """The pose of the crate at a tick: once around a circle with a radius of 5 cm."""
    angle = 2 * np.pi * min(k * PERIOD / TURN_S, 1.0)
    return START @ ulna.pose(xyz=(0.0, 0.05 * np.sin(angle), 0.05 - 0.05 * np.cos(angle)))


def show(view, ended):
    """Show the arm thirty times a second, in its own thread, since drawing must not delay the loop."""
    while not ended.wait(1 / 30):
        view.q = servo.q


def follow_page(tick_times):
    """Follow the crate that is dragged on a page, until Ctrl-C."""
    ended = threading.Event()
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: choose the crate in the tab Obstacles and drag it; Ctrl-C ends", flush=True)
        threading.Thread(target=show, args=(view, ended), daemon=True).start()
        try:
            for _ in ticks(sys.maxsize, tick_times):
                step()
        except KeyboardInterrupt:
            ended.set()


tick_times, min_distance = [], robot.signed_distance(robot.home, world)
servo.warm_up()  # compiles before the clock starts, which takes seconds on a new machine
servo.start(robot.home)
if "--view" in sys.argv:
    follow_page(tick_times)
else:
    for k in ticks(round((TURN_S + REST_S) / PERIOD), tick_times):
        world.move("crate", on_circle(k))
        q = step()
        min_distance = min(min_distance, robot.signed_distance(q, world)) if k % 10 == 0 else min_distance

if len(tick_times) > 1:
    periods = np.diff(tick_times)
    late = np.count_nonzero(periods > 1.5 * PERIOD)
    median, worst = 1e3 * np.median(periods), 1e3 * periods.max()
    print(f"{len(tick_times)} ticks, with a median period of {median:.3f} ms and a maximum of {worst:.3f} ms")
    print(f"{late} ticks were late by more than half a period" if late else "no tick was late")
print(", ".join(f"{status}: {n}" for status, n in status_counts.most_common()))
crate = world.pose("crate")
error = np.linalg.norm((robot.forward_kinematics(servo.q) - crate @ T_CRATE_HAND)[:3, 3])
print(f"the crate is at {crate[:3, 3].round(3)} m, the hand {1e3 * error:.2f} mm from its place above it")
assert (error < 1e-4 and min_distance > 0.01) or "--view" in sys.argv
