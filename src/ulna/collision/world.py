"""Holds the world around a robot: named shapes with poses in its base frame. Used by ``checker``, ``ik`` and the page."""

import threading

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.names import refuse_no_name
from ulna.collision.objects import Objects, make_objects
from ulna.description.clouds import Obstacle
from ulna.description.pose import as_one_pose
from ulna.errors import GeometryError, InputError, UnknownNameError


class World:
    """Obstacles by name. Objects may be added, moved and removed at any time, from any thread.

    Example:
        >>> from ulna.description.pose import pose
        >>> from ulna.description.shapes import Box
        >>> world = World()
        >>> world.add("crate", Box(extents=(0.15, 0.09, 0.126)), pose((0.5, 0, 0.21)))
        >>> world.names
        ('crate',)
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._shapes: dict[str, Obstacle] = {}
        self._poses: dict[str, NDArray[np.float64]] = {}
        self._objects: Objects | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objects, in the order in which they were added."""
        return tuple(self._shapes)

    def add(self, name: str, shape: Obstacle, pose: ArrayLike | None = None) -> None:
        """Add an object.

        Args:
            name: A name that no other object has.
            shape: A ``Box``, ``Sphere``, ``Capsule``, ``Cylinder``, ``ConvexMesh``, ``HalfSpace``, ``PointCloud`` or
                ``HeightMap``.
            pose: T_base_object, shape (4, 4); the origin unless given.

        Raises:
            GeometryError: The shape is not one of these.
            InputError: The name is taken or not text, or the pose is not a rigid motion.
        """
        _refuse_unsolid(name, shape)
        refuse_no_name(name)
        T = as_one_pose(np.eye(4) if pose is None else pose, "pose")
        with self._lock:
            if name in self._shapes:
                raise InputError("name", f"the world already has an object {name!r}; move() moves it")
            self._shapes[name], self._poses[name], self._objects = shape, T, None

    def move(self, name: str, pose: ArrayLike) -> None:
        """Put an object at another pose T_base_object, shape (4, 4).

        Raises:
            InputError: The pose is not a rigid motion.
            UnknownNameError: There is no such object.
        """
        T = as_one_pose(pose, "pose")
        with self._lock:
            self._known(name)
            self._poses[name], self._objects = T, None

    def reshape(self, name: str, shape: Obstacle) -> None:
        """Give an object another shape; it stays where it is.

        Raises:
            GeometryError: The shape is not one that a world can hold.
            UnknownNameError: There is no such object.
        """
        _refuse_unsolid(name, shape)
        with self._lock:
            self._known(name)
            self._shapes[name], self._objects = shape, None

    def remove(self, name: str) -> None:
        """Take an object away.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._known(name)
            del self._shapes[name], self._poses[name]
            self._objects = None

    def shape(self, name: str) -> Obstacle:
        """The shape of an object.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._known(name)
            return self._shapes[name]

    def pose(self, name: str) -> NDArray[np.float64]:
        """T_base_object, shape (4, 4).

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._known(name)
            return self._poses[name].copy()

    def items(self) -> tuple[tuple[str, Obstacle, NDArray[np.float64]], ...]:
        """The name, the shape and T_base_object, shape (4, 4), of every object: all of one moment.

        Example:
            >>> from ulna.description.pose import pose
            >>> from ulna.description.shapes import Sphere
            >>> world = World()
            >>> world.add("ball", Sphere(0.1), pose((0.5, 0, 0.25)))
            >>> [(name, shape, T[:3, 3].tolist()) for name, shape, T in world.items()]
            [('ball', Sphere(radius=0.1), [0.5, 0.0, 0.25])]
        """
        with self._lock:
            return tuple((name, shape, self._poses[name].copy()) for name, shape in self._shapes.items())

    def objects(self) -> Objects:
        """The objects as the kernels read them, of one moment; made anew only after a change."""
        with self._lock:
            if self._objects is None:
                self._objects = make_objects(self._shapes, self._poses)
            return self._objects

    def _known(self, name: str) -> None:
        if name not in self._shapes:
            raise UnknownNameError("object of the world", name, self._shapes)

    def __getstate__(self) -> dict:
        with self._lock:
            return {"_shapes": dict(self._shapes), "_poses": dict(self._poses)}

    def __setstate__(self, state: dict) -> None:
        self.__init__()
        self.__dict__.update(state)


def _refuse_unsolid(name: str, shape: object) -> None:
    if not isinstance(shape, Obstacle):
        kind = type(shape).__name__
        raise GeometryError(f"object {name!r} is a {kind}, which cannot be checked; ulna.ConvexMesh.from_points() makes a hull")
