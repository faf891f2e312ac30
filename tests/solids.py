"""Slow reference versions of collision shapes: points, support points and faces by definition; and random shapes."""

import itertools

import numpy as np

import formulas
import kernel_probes
import ulna
from assertions import assert_close
from matrix import matrix
from ulna.collision.rounded_shapes import shape_columns, shape_vertices
from ulna.kernels.distance.epa import SCRATCH

KINDS = ("sphere", "capsule", "box", "cylinder", "hull")
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in KINDS[i:]]
# As parameters: make test takes two closed forms, GJK alone, GJK with a radius, and what is round without one.
MATRIX = matrix(PAIRS, [("sphere", "box"), ("box", "box"), ("hull", "hull"), ("capsule", "hull"), ("box", "cylinder")])
POINTS = {
    "sphere": ulna.Sphere(0),
    "capsule": ulna.Capsule(radius=0, length=0),
    "box": ulna.Box((0, 0, 0)),
    "cylinder": ulna.Cylinder(radius=0, length=0),
    "hull": ulna.ConvexMesh([(0, 0, 0)]),
}
FLAT = {
    "sphere": ulna.Sphere(0),
    "capsule": ulna.Capsule(radius=0, length=0.8),
    "box": ulna.Box((1.2, 0.7, 0)),
    "cylinder": ulna.Cylinder(radius=0.5, length=0),
    "hull": ulna.ConvexMesh([(0.6, 0, 0), (0, 0.5, 0), (-0.4, -0.3, 0), (0.1, 0.1, 0)]),
}
OF_POLYTOPES = 1e-11
EXACTNESS = {"cylinder": 2e-9}  # the gap along the normal equals the distance to this many meters, for bodies of about one meter


def exactness(kinds):
    """The error of a distance that is allowed to two bodies of these kinds [m]."""
    return max(EXACTNESS.get(kind, OF_POLYTOPES) for kind in kinds)


def points_on_a_ball(rng, n):
    directions = rng.normal(size=(n, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None]


def random_solid(rng, kind, scale=1.0):
    x, y, z = scale * rng.uniform(0.05, 0.6, 3)
    return {
        "sphere": lambda: ulna.Sphere(x),
        "capsule": lambda: ulna.Capsule(radius=x, length=2 * y),
        "box": lambda: ulna.Box((2 * x, 2 * y, 2 * z)),
        "cylinder": lambda: ulna.Cylinder(radius=x, length=2 * y),
        "hull": lambda: ulna.ConvexMesh(points_on_a_ball(rng, 9) * (x, y, z) + 0.1 * x),
    }[kind]()


def scaled_by(shape, s):
    match shape:
        case ulna.Sphere(radius):
            return ulna.Sphere(s * radius)
        case ulna.Box(extents):
            return ulna.Box(tuple(s * e for e in extents))
        case ulna.ConvexMesh(vertices=vertices):
            return ulna.ConvexMesh(s * vertices)
    return type(shape)(radius=s * shape.radius, length=s * shape.length)


def random_pose(rng, spread=1.0):
    return formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi)), rng.normal(size=3) * spread)


def kernel_arguments(shape_a, shape_b):
    """Kind and vertices of both, as the probe of a pair takes them (a read-only array would be compiled for anew)."""
    kinds = [int(shape_columns(shape)[0]) for shape in (shape_a, shape_b)]
    return kinds[0], shape_vertices(shape_a).copy(), kinds[1], shape_vertices(shape_b).copy()


def kernel_column(shape, T):
    """Pose, half extents and radius: sixteen numbers."""
    return [*T[:3].ravel(), *shape_columns(shape)[1:5]]


def farthest(shape, T, n):
    """The farthest point of a shape at pose T along the unit vector n."""
    d = T[:3, :3].T @ n
    match shape:
        case ulna.Sphere(radius):
            p = radius * d
        case ulna.Capsule():
            p = shape.radius * d + np.array([0, 0, np.sign(d[2]) * shape.length / 2])
        case ulna.Box():
            p = np.sign(d) * shape.half_extents
        case ulna.Cylinder():
            across = np.hypot(d[0], d[1])
            p = np.array([*(shape.radius * d[:2] / across if across > 0 else (0, 0)), np.sign(d[2]) * shape.length / 2])
        case ulna.ConvexMesh():
            p = shape.vertices[np.argmax(shape.vertices @ d)]
    return T[:3, :3] @ p + T[:3, 3]


def gap_along(a, T_a, b, T_b, n):
    """The gap between the shadows of two shapes along a unit vector from a to b: never more than their signed distance."""
    return (farthest(b, T_b, -n) - farthest(a, T_a, n)) @ n


def outside(shape, T, p):
    """How far the point p stands out of a shape, measured along a face's normal or from an axis: at most 0 within."""
    c = T[:3, :3].T @ (p - T[:3, 3])
    match shape:
        case ulna.Sphere(radius):
            return np.linalg.norm(c) - radius
        case ulna.Capsule():
            return np.linalg.norm(c - [0, 0, np.clip(c[2], -shape.length / 2, shape.length / 2)]) - shape.radius
        case ulna.Box():
            return (abs(c) - shape.half_extents).max()
        case ulna.Cylinder():
            return max(np.hypot(c[0], c[1]) - shape.radius, abs(c[2]) - shape.length / 2)
        case ulna.HalfSpace():
            return c[2]
    return max(n @ c - offset for n, offset in hull_planes(shape.vertices))


def hull_planes(vertices):
    """Normal and offset of every plane through three points that has all others on one side."""
    for i, j, k in itertools.combinations(range(len(vertices)), 3):
        n = np.cross(vertices[j] - vertices[i], vertices[k] - vertices[i])
        n /= np.linalg.norm(n)
        heights = (vertices - vertices[i]) @ n
        for side in (1, -1):
            if (side * heights).max() < 1e-12:
                yield side * n, side * n @ vertices[i]


def widest_gap_found(a, T_a, b, T_b, rng, rounds=6):
    """The widest gap over many directions, drawn ever closer to the best: from below towards the signed distance."""
    best, spread = points_on_a_ball(rng, 400), 0.5
    for _ in range(rounds):
        best = best[np.argsort([-gap_along(a, T_a, b, T_b, n) for n in best])[:8]]
        near = (best[:, None] + spread * rng.normal(size=(8, 25, 3))).reshape(-1, 3)
        best, spread = np.vstack([best, near / np.linalg.norm(near, axis=1)[:, None]]), spread / 4
    return max(gap_along(a, T_a, b, T_b, n) for n in best)


def random_pairs(rng, kinds, n, spread=0.3):
    a, b = (random_solid(rng, kind) for kind in kinds)
    fresh = [tuple(shape if kind == "hull" else random_solid(rng, kind) for kind, shape in zip(kinds, (a, b), strict=True))
             for _ in range(n)]  # fmt: skip
    return [(x, random_pose(rng, spread), y, random_pose(rng, spread)) for x, y in fresh]


def ask(run, pairs):
    """Distances, points of a, points of b, normals and verdicts of pairs (a, T_a, b, T_b) whose kinds and hulls are the same."""
    columns = [[*kernel_column(a, T_a), *kernel_column(b, T_b)] for a, T_a, b, T_b in pairs]
    scratch = tuple(np.zeros(shape) for shape in SCRATCH)
    out = run(kernel_probes.two_bodies, np.transpose(columns), 11, *kernel_arguments(pairs[0][0], pairs[0][2]), scratch)
    return out[0], out[1:4].T, out[4:7].T, out[7:10].T, out[10] == 1.0


def assert_proved(pairs, answer, exactness=1e-11):
    """The points lie on the shapes, as far apart along the normal as the answer says, and so far apart are the shadows there."""
    for (a, T_a, b, T_b), d, p, q, n, overlap in zip(pairs, *answer, strict=True):
        assert_close(np.linalg.norm(n), 1, atol=1e-12)
        assert_close(q - p, d * n, atol=1e-12 + 1e-15 * abs(d))
        assert outside(a, T_a, p) < exactness
        assert outside(b, T_b, q) < exactness
        assert_close(gap_along(a, T_a, b, T_b, n), d, atol=exactness)
        assert overlap == (d <= 0) or abs(d) < 1e-3 * exactness
