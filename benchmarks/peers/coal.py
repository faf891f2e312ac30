"""Runs Pinocchio's kinematics with Coal's shapes: a robot, a world, and the checked pairs."""

import coal
import numpy as np
import pinocchio as pin

from benchmarks.peer import NotForThisArm, bare_urdf
from ulna.collision.clouds import PointCloud
from ulna.collision.world import World
from ulna.description.shapes import Box, Capsule, ConvexMesh, Cylinder, Sphere
from ulna.robot import Robot


def of_coal(shape):
    """Convert a shape to Coal.

    Raises:
        NotForThisArm: Its kind is not compared.
    """
    match shape:
        case Box(extents):
            return coal.Box(*extents)
        case Sphere(radius):
            return coal.Sphere(radius)
        case Cylinder(radius, length):
            return coal.Cylinder(radius, length)
        case Capsule():
            return coal.Capsule(shape.radius, shape.length)
        case ConvexMesh():
            points = coal.StdVec_Vec3s()
            points.extend(list(shape.vertices))
            return coal.Convex.convexHull(points, True, "Qt")  # noqa: FBT003 - keep the triangles
    raise NotForThisArm(f"{type(shape).__name__} is not compared")


def solids_of(shape) -> list:
    """The convex shapes of an object, each with its pose in it; for a cloud a ball around each point."""
    if isinstance(shape, PointCloud):
        return [(Sphere(shape.radius), pin.SE3(np.eye(3), np.array(point, dtype=float))) for point in shape.points]
    return [(shape, pin.SE3.Identity())]


class Scene:
    """A robot and a world in Pinocchio; with ``itself``, the robot's pairs that Ulna checks, by number."""

    def __init__(self, robot: Robot, world: World, *, itself: bool) -> None:
        self.model = pin.buildModelFromXML(bare_urdf(robot))
        self.data, self.geometry = self.model.createData(), pin.GeometryModel()
        bodies, names = [], iter(robot.collision_names)
        for link in robot.description.links:
            frame = self.model.frames[self.model.getFrameId(link.name)]
            for body in link.collisions:
                placement = frame.placement * pin.SE3(body.pose)
                bodies.append(self._add(next(names), frame.parentJoint, placement, body.shape))
        self.parts = {name: solids_of(world.shape(name)) for name in world.names}
        for name, parts in self.parts.items():
            for k, (shape, at) in enumerate(parts):
                other = self._add(f"world {name} {k}", 0, pin.SE3(world.pose(name)) * at, shape)
                for body in bodies:
                    self.geometry.addCollisionPair(pin.CollisionPair(body, other))
        if itself:
            for i, j in robot._checker.pairs:  # noqa: SLF001 - the pairs by number, so that both check the same
                self.geometry.addCollisionPair(pin.CollisionPair(bodies[i], bodies[j]))
        self.answers = self.geometry.createData()

    def _add(self, name: str, joint: int, placement, shape) -> int:
        return self.geometry.addGeometryObject(pin.GeometryObject(name, joint, placement, of_coal(shape)))

    def move(self, name: str, T) -> None:
        """Move an object of the world."""
        for k, (_, at) in enumerate(self.parts[name]):
            number = self.geometry.getGeometryId(f"world {name} {k}")
            self.geometry.geometryObjects[number].placement = pin.SE3(T) * at

    def collides(self, q) -> bool:
        """Whether any pair touches; it stops at the first."""
        return pin.computeCollisions(self.model, self.data, self.geometry, self.answers, q, True)  # noqa: FBT003

    def distances(self, q) -> int:
        """Compute the distances of all pairs into ``answers``; returns the index of the nearest."""
        return pin.computeDistances(self.model, self.data, self.geometry, self.answers, q)

    def least_distance(self, q) -> float:
        """The distance of the nearest pair [m]."""
        return float(self.answers.distanceResults[self.distances(q)].min_distance)

    @property
    def n_pairs(self) -> int:
        """The number of checked pairs."""
        return len(self.geometry.collisionPairs)


def disagreement(scene: Scene, robot: Robot, world: World, q, *, itself: bool) -> str:
    """The disagreement between the scene and Ulna for rows of q; "" if none.

    For overlapping boxes only the sign is compared: Coal's depth is that of a search.
    """
    touches = np.array([scene.collides(x) for x in q])
    differ = np.count_nonzero(touches != robot.in_collision(q, world, self_collision=itself))
    theirs, ours = np.array([scene.least_distance(x) for x in q]), robot.signed_distance(q, world, self_collision=itself)
    off = float(np.abs(np.maximum(theirs, 0.0) - np.maximum(ours, 0.0)).max())
    if differ:
        return f"{differ} of {len(q)} verdicts differ"
    return f"its distances differ by {off:.1e} m" if not off <= 1e-6 else ""
