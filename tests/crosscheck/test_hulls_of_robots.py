"""A robot whose meshes are taken as their hulls: Pinocchio reads the same meshes, Coal makes their hulls and measures."""

from functools import cache

import coal
import numpy as np
import pinocchio as pin
import pytest

import ulna
from assertions import assert_close
from coal_pairs import coal_request
from pinocchio_peer import Peer

ROBOTS = ("ur5", "xarm", "kinova")
N = 40


@cache
def robot_of(name):
    return ulna.load(name).with_convex_hulls()


@cache
def peer_of(name):
    """The robot in Pinocchio, and its collision geometries, each mesh the hull that Coal makes of its points."""
    robot = robot_of(name)
    text = robot.to_urdf(mesh_paths="file")
    model = pin.buildModelFromXML(text, mimic=True)
    geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    for one in geometry.geometryObjects:
        if isinstance(one.geometry, coal.BVHModelBase):
            points = coal.StdVec_Vec3s()
            points.extend(list(one.geometry.vertices() * one.meshScale.T))
            one.geometry = coal.Convex.convexHull(points, True, "Qt")
    geometry.addAllCollisionPairs()
    return Peer(robot, model), geometry


def distance_of(peer, geometry, q, kept):
    """The least signed distance of pairs of geometries whose links both are in a pair of ``kept``."""
    data = geometry.createData()
    pin.updateGeometryPlacements(peer.model, peer.data, geometry, data, peer.configuration(q))
    found = np.inf
    for pair in geometry.collisionPairs:
        one, other = (geometry.geometryObjects[k] for k in (pair.first, pair.second))
        if frozenset(peer.model.frames[g.parentFrame].name for g in (one, other)) in kept:
            places = (data.oMg[k] for k in (pair.first, pair.second))
            T_a, T_b = (coal.Transform3s(T.rotation, T.translation) for T in places)
            found = min(found, coal.distance(one.geometry, T_a, other.geometry, T_b, coal_request(1e-9), coal.DistanceResult()))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_distances_of_the_robot_from_itself_are_those_of_coal(name, rng):
    robot, (peer, geometry) = robot_of(name), peer_of(name)
    kept = {frozenset(pair.links) for pair in robot.allowed_collisions.checked}
    q = rng.uniform(np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi), (N, robot.n_dof))
    distances = robot.signed_distance(q)
    expected = np.array([distance_of(peer, geometry, one, kept) for one in q])
    apart = expected > 0
    assert 3 < apart.sum() <= N
    assert_close(distances[apart], expected[apart], atol=2e-6)
    assert (distances[~apart] <= 0).all()
    assert_close(robot.in_collision(q), ~apart)
