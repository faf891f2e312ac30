"""Makes scenes and hostile commands for servos, and judges the servos' commands."""

import numpy as np

import ulna

RATE = 1000
FINER = 16  # times: the judge looks at so many configurations a tick


def boxes(n, seed):
    """A world of boxes about the Panda, none of which touches it at home with 20 mm to spare."""
    panda, world, rng = ulna.load("panda"), ulna.World(), np.random.default_rng(seed)
    while len(world.names) < n:
        name, place = f"box {len(world.names)}", ulna.pose(rng.uniform([-0.7, -0.7, 0.0], [0.7, 0.7, 0.9]), rng.uniform(-3, 3, 3))
        world.add(name, ulna.Box(rng.uniform(0.05, 0.3, 3)), place)
        if panda.signed_distance(panda.home, world) < 0.02:
            world.remove(name)
    return world


def mixed():
    """A floor, a ball, a post and a point cloud."""
    world, rng = ulna.World(), np.random.default_rng(3)
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -0.05)), touch_links=["panda_link0"])
    world.add("ball", ulna.Sphere(0.15), ulna.pose((0.55, 0.35, 0.4)))
    world.add("post", ulna.Cylinder(0.05, 1.2), ulna.pose((0.45, -0.35, 0.6)))
    world.add("cloud", ulna.PointCloud(rng.uniform([0.6, -0.2, 0.2], [0.9, 0.2, 0.8], (2000, 3)), 0.01))
    return world


def hostile(robot, servo, n, seed):
    """The commands of n ticks: goals of each kind that jump, through walls and into the robot, and noise."""
    rng = np.random.default_rng(seed)
    goal, until = {}, 0
    for k in range(n):
        if k == until:
            until += int(rng.choice([13, 97, 997]))
            kind, far = rng.integers(6), robot.random(1, seed=int(rng.integers(2**31)))[0]
            twist = rng.normal(size=6) * rng.choice([0.3, 3.0])
            goal = [
                {"velocity": rng.choice([-1, 1], robot.n_dof) * rng.choice([0.5, 100.0])},
                {"q": far},
                {"twist": twist, "expressed_in": str(rng.choice(["base", "link", "spatial"]))},
                {"pose": robot.forward_kinematics(far)},
                {"pose": ulna.pose(rng.uniform([-0.3, -0.3, 0.0], [0.3, 0.3, 0.6]), rng.uniform(-3, 3, 3))},
                {},
            ][kind]
        if k % 100 > 80 and "velocity" in goal:
            goal = {"velocity": rng.normal(size=robot.n_dof) * 3}
        yield servo.step(**goal)


def judge(robot, world, start, commands, acceleration, rate=RATE):
    """The contacts, and the greatest shares of the limits of velocity and acceleration, of all that was commanded."""
    q = np.array([start.q, *(c.q for c in commands)])
    qd = np.array([start.qd, *(c.qd for c in commands)])
    h, t = 1 / rate, np.arange(FINER)[:, None, None] / FINER / rate
    a = np.diff(qd, axis=0) / h
    fine = q[None, :-1] + t * qd[None, :-1] + 0.5 * t * t * a[None]
    contacts = np.count_nonzero(robot.in_collision(fine.reshape(-1, robot.n_dof), world))
    by_difference = np.diff(q, axis=0) / h
    assert np.abs(q[1:] - q[:-1] - h * (qd[1:] + qd[:-1]) / 2).max() < 1e-12  # the curve is what the state says
    assert np.abs(np.array([c.qdd for c in commands]) - a).max() < 1e-6 * acceleration
    return {
        "contacts": int(contacts),
        "velocity": float((np.abs(by_difference) / robot.velocity_limits).max()),
        "acceleration": float(np.abs(a).max() / acceleration),
        "by differences": float(np.abs(np.diff(by_difference, axis=0) / h).max() / acceleration),
        "beyond": float(np.maximum(robot.lower - fine, fine - robot.upper).max()),
    }


def judge_jerk(robot, world, start, commands, limits, rate=RATE):
    """What ``judge`` finds where ticks have a constant jerk: at FINER times of each tick, and by differences of commands.

    limits: those of velocity, acceleration and jerk that were asked for.
    """
    q, v, a = (np.array([getattr(c, name) for c in (start, *commands)]) for name in ("q", "qd", "qdd"))
    h, t = 1 / rate, np.arange(FINER)[:, None, None] / FINER / rate
    jerk = np.diff(a, axis=0) / h
    fine = q[:-1] + t * (v[:-1] + t * (a[:-1] / 2 + t * jerk / 6))
    speeds = v[:-1] + t * (a[:-1] + t * jerk / 2)
    assert np.abs(q[1:] - (q[:-1] + h * (v[:-1] + h * (2 * a[:-1] + a[1:]) / 6))).max() < 1e-13  # the state says so
    assert np.abs(v[1:] - (v[:-1] + h * (a[:-1] + a[1:]) / 2)).max() < 1e-12
    shares = [np.abs(x) / limit for x, limit in zip((speeds, a, jerk), limits, strict=True)]
    shares += [np.abs(np.diff(q, n, axis=0)) / h**n / limit for n, limit in enumerate(limits, start=1)]
    return {
        "contacts": int(np.count_nonzero(robot.in_collision(fine.reshape(-1, robot.n_dof), world))),
        "shares": [float(share.max()) for share in shares],
        "beyond": float(np.maximum(robot.lower - fine, fine - robot.upper).max()),
    }
