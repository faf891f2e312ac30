"""Makes edges that are known to be collisions, since at one configuration a point lies in both bodies.

The point lies inside the body of the world, at a given share of the path from its surface to its middle. The robot's body is
placed so that its farthest point along the inward normal of the face is this point, whatever its rotation. No library decides.
"""

import numpy as np

import formulas
import solids
import ulna

KINDS = ("box", "cylinder", "hull", "capsule", "sphere")
OBSTACLES = (*KINDS, "cloud")
_MOVER = (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"), ("c", "0 0 1"), ("b", "0 1 0"), ("a", "1 0 0"))


def mover(shape, T, turns=False):
    """A robot that slides along x, y and z, turns about z, y and x, and holds a shape at T; with ``turns`` a mimic turns too."""
    text, parent = '<robot name="mover"><link name="base"/>', "base"
    for name, axis in (*_MOVER, ("mimic", "0 0 1")) if turns else _MOVER:
        kind, follows = ("prismatic", "") if name in "xyz" else ("continuous", "")
        limit = '<limit lower="-20000" upper="20000" effort="1" velocity="1"/>' if kind == "prismatic" else ""
        if name == "mimic":
            follows, limit = '<mimic joint="a" multiplier="-3" offset="0.5"/>', ""
        text += f'<link name="of_{name}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="of_{name}"/>'
        text, parent = f'{text}<axis xyz="{axis}"/>{limit}{follows}</joint>', f"of_{name}"
    middle = shape.vertices.mean(axis=0) if isinstance(shape, ulna.ConvexMesh) else np.zeros(3)
    place = " ".join(map(repr, (T[:3, :3] @ middle + T[:3, 3]).tolist()))
    point = f'<collision><origin xyz="{place}"/><geometry><sphere radius="0"/></geometry></collision>'  # its own
    text = text.replace(f'<link name="{parent}"/>', f'<link name="{parent}">{point}</link>')
    return ulna.load(text + "</robot>").with_attached("held", shape, T, link=parent)


def extreme_solid(rng, kind):
    """A needle, a plate of kilometers, a crumb, or something usual."""
    sizes = 10 ** rng.uniform([-2, -2, -4], [rng.choice([0.5, 2.5, 3.8]), rng.choice([0, 3.8]), -0.5])
    sizes = rng.permutation(sizes) if kind in ("box", "hull") else sizes
    return {
        "box": lambda: ulna.Box(sizes),
        "cylinder": lambda: ulna.Cylinder(min(sizes) / 2, max(sizes)),
        "capsule": lambda: ulna.Capsule(min(sizes) / 2, max(sizes)),
        "sphere": lambda: ulna.Sphere(sizes[0]),
        "hull": lambda: ulna.ConvexMesh(corners(sizes) if rng.random() < 0.5 else solids.points_on_a_ball(rng, 12) * sizes / 2),
        "cloud": lambda: ulna.PointCloud(rng.uniform(-0.5, 0.5, (rng.integers(1, 100), 3)) * sizes, min(sizes) / 2),
    }[kind]()


def corners(sizes):
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * sizes / 2


def surface_point(rng, shape):
    """A point of a shape's surface, the outward normal there, and a point in its middle, in its own frame."""
    u = solids.points_on_a_ball(rng, 1)[0]
    round_ = np.array([u[0], u[1], 0]) / np.hypot(u[0], u[1])
    match shape:
        case ulna.Box():
            p, k = rng.uniform(-1, 1, 3) * shape.half_extents, np.argmin(shape.half_extents)
            p[k] = shape.half_extents[k]
            return p, np.eye(3)[k], p * (np.arange(3) != k)
        case ulna.Cylinder() | ulna.Capsule():
            middle = np.array([0, 0, rng.uniform(-0.5, 0.5) * shape.length])
            return middle + shape.radius * round_, round_, middle
        case ulna.Sphere():
            return shape.radius * u, u, np.zeros(3)
        case ulna.PointCloud():
            middle = shape.points[rng.integers(len(shape.points))]
            return middle + shape.radius * u, u, middle
    flat = np.eye(3)[np.argmin(np.ptp(shape.vertices, axis=0))]
    n = flat if rng.random() < 0.7 else u
    heights = shape.vertices @ n
    top = shape.vertices[heights >= heights.max() - 1e-12 * np.abs(heights).max()]
    return rng.dirichlet(np.ones(len(top))) @ top, n, shape.vertices.mean(axis=0)


def grazing_edges(rng, kind, obstacle, n):
    """A robot, a world, and the ends of n edges that pass through a configuration where the two share a point."""
    shape, target = extreme_solid(rng, kind), extreme_solid(rng, obstacle)
    T_object, T_held, turns = solids.random_pose(rng), solids.random_pose(rng, 0.1), rng.random() < 0.3
    robot, world = mover(shape, T_held, turns), ulna.World()
    world.add("target", target, T_object)
    q = np.array([_touching(rng, shape, target, T_object, T_held, turns) for _ in range(n)])
    noise = 10 ** rng.uniform(-9, -3, (n, 1)) * rng.normal(size=(n, 6)) * np.repeat([1.0, rng.random() < 0.5], 3)
    way = q[:, 1] + noise
    beyond = (rng.random((n, 1)) < 0.5) * 10 ** rng.uniform(-3, 0, (n, 1))
    return robot, world, q[:, 0] + way, q[:, 0] - beyond * way


def _touching(rng, shape, target, T_object, T_held, turns):
    """q at which a point of the shape lies within the target, and a way in q that leads out of it."""
    surface, normal, middle = surface_point(rng, target)
    inside = surface + 10 ** rng.uniform(-3, -0.3) * (middle - surface)
    angles = rng.uniform(-3, 3, 3) + 2 * np.pi * rng.integers(-1, 2, 3) * 10.0 ** rng.integers(0, 3)
    if rng.random() < 0.3:
        angles[:] = rng.choice([0, np.pi / 2, np.pi], 3) + rng.choice([0, 1e-9, 1e-6, 1e-4]) * rng.normal(size=3)
    c, b, a = angles
    R = formulas.rotation([0, 0, 1], c) @ formulas.rotation([0, 1, 0], b) @ formulas.rotation([1, 0, 0], a)
    if turns:
        R = R @ formulas.rotation([0, 0, 1], 0.5 - 3 * a)
    T = formulas.transform(R) @ T_held
    out = T_object[:3, :3] @ normal
    deepest = solids.farthest(shape, T, -out)
    place = T_object[:3, :3] @ inside + T_object[:3, 3] - deepest
    depth = np.linalg.norm(surface - inside)
    way = 10 ** rng.uniform(-7, -1) if rng.random() < 0.5 else depth * (1 + 10 ** rng.uniform(-3, 2))
    return np.array([[*place, *angles], [*way * out, 0, 0, 0]])
