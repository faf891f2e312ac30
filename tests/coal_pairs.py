"""Computes signed distances and normals of pairs of shapes with Coal."""

import coal
import numpy as np

import ulna


def as_coal(shape):
    match shape:
        case ulna.Sphere(radius):
            return coal.Sphere(radius)
        case ulna.Capsule():
            return coal.Capsule(shape.radius, shape.length)
        case ulna.Box(extents):
            return coal.Box(*extents)
        case ulna.Cylinder():
            return coal.Cylinder(shape.radius, shape.length)
        case ulna.HalfSpace():
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
    points = coal.StdVec_Vec3s()
    points.extend(list(shape.vertices))
    return coal.Convex.convexHull(points, True, "Qt")


def coal_request(tolerance):
    """A request for answers as exact as Coal gives them: its own tolerance is 1e-6. Too small a one and its search fails."""
    request = coal.DistanceRequest()
    request.gjk_tolerance = request.epa_tolerance = tolerance
    return request


def coal_scene(pairs):
    """Arguments of ``coal.distance`` for every pair (a, T_a, b, T_b); equal shapes are made once."""
    made = {}

    def shape(of):
        if id(of) not in made:
            made[id(of)] = as_coal(of)
        return made[id(of)]

    def place(T):
        return coal.Transform3s(T[:3, :3], T[:3, 3])

    return [(shape(a), place(T_a), shape(b), place(T_b)) for a, T_a, b, T_b in pairs]


def coal_distances(scene, tolerance):
    request = coal_request(tolerance)
    return np.array([coal.distance(*arguments, request, coal.DistanceResult()) for arguments in scene])
