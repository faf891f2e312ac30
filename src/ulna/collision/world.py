"""Holds the world around a robot: named shapes with poses in its base frame."""

import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.entries import placing
from ulna.collision.grids import Obstacle
from ulna.collision.object_tables import ObjectTables
from ulna.collision.objects import Objects
from ulna.description.arrays import as_number
from ulna.description.likely_units import check_object, check_place, check_speed
from ulna.description.name_checks import as_link_names, refuse_no_name
from ulna.description.pose import as_one_pose, as_pose, orthonormal
from ulna.description.shapes import Solid
from ulna.engine.bound import IN_C, bind
from ulna.errors import GeometryError, InputError, UnknownNameError, count_of
from ulna.notebook.recording import Recording, drawer
from ulna.notebook.tables import table

_MAX_SHOWN = 6  # objects
_CONTENTS = "_shapes", "_poses", "_touch_links", "_speeds", "_update_numbers"


class WorldState(NamedTuple):
    """The objects of a world at one moment, by name. Shapes and poses are the world's own.

    Attributes:
        number: The number of changes of the world up to this moment.
        shapes: The shapes.
        poses: T_base_object, shape (4, 4).
        touch_links: The links that may touch an object, if there are any.
    """

    number: int
    shapes: dict[str, Obstacle]
    poses: dict[str, NDArray[np.float64]]
    touch_links: dict[str, frozenset[str]]


class World:
    """Obstacles by name. Objects may be added, moved and removed at any time, from any thread.

    An interrupted change, as by Ctrl-C, is applied completely or not at all.

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
        self._touch_links: dict[str, frozenset[str]] = {}
        self._tables: ObjectTables | None = None  # None: all objects need a new layout
        self._speeds: dict[str, float] = {}  # of the objects that may move by themselves
        self._update_numbers: dict[str, int] = {}  # the number of the last pose update of each of these
        self._n_updates = 0  # pose updates of the world
        self._n_changes = 0  # other changes of the world
        self._changed: dict[str, bool] = {}  # since _objects was made; True if more than the pose changed
        self._objects: Objects | None = None
        self._snapshot: tuple[Objects | None, World | None] = (None, None)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objects, in the order in which they were added."""
        return tuple(self._shapes)

    def __contains__(self, name: object) -> bool:
        return name in self._shapes

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self._shapes)

    def __bool__(self) -> bool:
        """Always True: ``world or World()`` must not replace an empty world, which may be filled later."""
        return True

    def add(
        self,
        name: str,
        shape: Obstacle,
        pose: ArrayLike | None = None,
        *,
        touch_links: Iterable[str] = (),
        speed: float | None = None,
    ) -> None:
        """Add an object.

        Args:
            name: A name that no other object has.
            shape: A ``Solid``, such as a ``Box``, a ``ConvexMesh`` or a ``HalfSpace``; or a ``PointCloud``, ``HeightMap`` or
                ``VoxelGrid``.
            pose: T_base_object, shape (4, 4); the origin unless given.
            touch_links: Links of a robot, or objects attached to it, that may touch this object. Their contact is no collision,
                and their distance does not count. An example is the base on the floor. Names that a robot does not have are
                ignored.
            speed: The maximum speed of any point of an object that may move by itself [m/s]. Only a servo uses it: it stays clear
                of everywhere the object can have moved to (docs/servo.md). Objects without a speed stay at their pose until
                ``move``.

        Raises:
            GeometryError: The shape is of another type.
            InputError: The name is taken or not text, the pose is not a rigid motion, or the speed is not a number of at least 0.

        Example:
            >>> import ulna
            >>> panda, world = ulna.load("panda"), World()
            >>> world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, 0.01)), touch_links=["panda_link1"])
            >>> panda.in_collision(panda.home, world)
            False
        """
        refuse_no_name(name)
        _refuse_unsolid(name, shape)
        T, links = _pose_copier()(np.eye(4) if pose is None else pose), as_link_names(touch_links)
        fastest = None if speed is None else as_number("speed", speed, 0.0, "a speed [m/s] of at least 0")
        check_object(name, shape, T)
        if fastest is not None:
            check_speed(fastest)
        with self._lock:
            if name in self._shapes:
                raise InputError("name", f"the world already has an object {name!r}; move() moves it")
            self._mark_changed(name)
            self._shapes[name], self._poses[name] = shape, T
            if fastest is not None:
                self._speeds[name], self._update_numbers[name] = fastest, self._n_updates
            if links:
                self._touch_links[name] = links

    def add_many(
        self,
        objects: Iterable[tuple[str, Obstacle] | tuple[str, Obstacle, ArrayLike]],
        *,
        touch_links: Iterable[str] = (),
    ) -> None:
        """Add several objects, all or none.

        Args:
            objects: The name, the shape, and T_base_object, shape (4, 4), of each, in the order of ``items``. The pose is
                optional.
            touch_links: As in ``add``, for all of these objects.

        Raises:
            GeometryError: A shape is of a type that a world cannot hold.
            InputError: A name is taken, given twice or not text, or a pose is not a rigid motion.

        Example:
            >>> import ulna
            >>> world = World()
            >>> world.add_many((f"post {k}", ulna.Box((0.1, 0.1, 1)), ulna.pose((1, 0.3 * k, 0))) for k in range(3))
            >>> world.names
            ('post 0', 'post 1', 'post 2')
        """
        new, links = World(), as_link_names(touch_links)
        for name, shape, *pose in objects:
            new.add(name, shape, *pose, touch_links=links)
        with self._lock:
            for name in new._shapes:
                if name in self._shapes:
                    raise InputError("name", f"the world already has an object {name!r}; move() moves it")
            self._exchange((), new.__getstate__())

    def move(self, name: str, pose: ArrayLike) -> None:
        """Move an object to another pose T_base_object, shape (4, 4).

        For an object with a speed this is a pose update: a servo takes it as the object's pose now.

        Raises:
            InputError: The pose is not a rigid motion.
            UnknownNameError: There is no such object.
        """
        T = _pose_copier()(pose)
        check_place("pose", T)
        with self._lock:
            self._check_name(name)
            self._mark_changed(name, pose_alone=True)
            self._poses[name] = T
            if name in self._speeds:
                self._update_numbers[name] = self._n_updates

    def move_many(self, names: Sequence[str], poses: ArrayLike) -> None:
        """Move several objects, all or none. A query in another thread sees all of them moved, or none.

        Args:
            names: The objects.
            poses: T_base_object of each, shape (n, 4, 4).

        Raises:
            InputError: The numbers of poses and names differ, or a pose is not a rigid motion.
            UnknownNameError: There is no such object.

        Example:
            >>> import ulna
            >>> world = World()
            >>> world.add_many([("a", ulna.Sphere(0.1)), ("b", ulna.Sphere(0.2))])
            >>> world.move_many(["a", "b"], ulna.pose([(1, 0, 0), (0, 1, 0)]))
            >>> world.pose("b")[:3, 3]
            array([0., 1., 0.])
        """
        rigid = orthonormal(as_pose(poses, "poses"))
        if isinstance(names, str) or rigid.ndim != 3 or len(rigid) != len(names):
            raise InputError("poses", f"shape {rigid.shape}; one pose for each of {count_of(len(names), 'name')} is expected")
        if len(rigid):
            check_place("poses", rigid[np.linalg.norm(rigid[:, :3, 3], axis=1).argmax()])
        with self._lock:
            for name in names:
                self._check_name(name)
            new_poses = dict(zip(names, rigid, strict=True))
            for name in new_poses:
                self._mark_changed(name, pose_alone=True)
            updates = {name: self._n_updates for name in new_poses if name in self._speeds}
            self._poses, self._update_numbers = {**self._poses, **new_poses}, {**self._update_numbers, **updates}

    def reshape(self, name: str, shape: Obstacle) -> None:
        """Give an object another shape; its pose is unchanged.

        Raises:
            GeometryError: The shape is of a type that a world cannot hold.
            UnknownNameError: There is no such object.
        """
        _refuse_unsolid(name, shape)
        check_object(name, shape, np.eye(4))
        with self._lock:
            self._check_name(name)
            self._mark_changed(name)
            is_image = not isinstance(shape, Solid)  # a sensor's image is a pose update too
            self._shapes[name] = shape
            if is_image and name in self._speeds:
                self._update_numbers[name] = self._n_updates

    def update(self, name: str, points: PointCloud | ArrayLike) -> None:
        """Replace the points of a cloud. Its pose and its ``touch_links`` are unchanged.

        Its radius changes only if a ``PointCloud`` is given. This is the fastest way to bring a camera's next image into the
        world: only this cloud is laid out again.

        Args:
            name: The object, which is a ``PointCloud``.
            points: A ``PointCloud``, or points as its constructor takes them, shape (n, 3) or (H, W, 3) [m].

        Raises:
            InputError: They are not points, or the object is no cloud.
            UnknownNameError: There is no such object.

        Example:
            >>> import ulna
            >>> world = World()
            >>> world.add("seen", ulna.PointCloud([(0.5, 0, 0.2)], radius=0.01))
            >>> world.update("seen", [(0.6, 0, 0.2), (0.6, 0.1, 0.2)])
            >>> world.shape("seen")
            PointCloud(2 points, radius 0.01 m)
        """
        shape = self.shape(name)
        if not isinstance(shape, PointCloud):
            raise InputError(
                "name", f"{name!r} is a {type(shape).__name__}, not a PointCloud; reshape() gives an object another shape"
            )
        self.reshape(name, points if isinstance(points, PointCloud) else PointCloud(points, shape.radius))

    def remove(self, name: str) -> None:
        """Remove an object.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._check_name(name)
            self._mark_changed(name)
            del self._shapes[name], self._poses[name]
            if name in self._touch_links:
                del self._touch_links[name]
            if name in self._speeds:
                del self._speeds[name], self._update_numbers[name]

    def shape(self, name: str) -> Obstacle:
        """The shape of an object.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._check_name(name)
            return self._shapes[name]

    def pose(self, name: str) -> NDArray[np.float64]:
        """T_base_object, shape (4, 4).

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._check_name(name)
            return self._poses[name].copy()

    def touch_links(self, name: str) -> frozenset[str]:
        """The links, or attached objects, that may touch an object.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._check_name(name)
            return self._touch_links.get(name, frozenset())

    def speed(self, name: str) -> float | None:
        """The maximum speed of an object that may move by itself [m/s], or None.

        Raises:
            UnknownNameError: There is no such object.
        """
        with self._lock:
            self._check_name(name)
            return self._speeds.get(name)

    def copy(self) -> "World":
        """An independent copy with the same objects."""
        other = World()
        with self._lock:
            other.__setstate__(self._contents())
            other._objects, other._changed = self._objects, dict(self._changed)
            other._tables = self._tables.copy() if self._tables else None
        return other

    def snapshot(self) -> "World":
        """A copy that nobody changes; the same copy until an object changes."""
        objects = self.objects()  # computed once, and shared with the copy
        known, snapshot = self._snapshot
        if snapshot is None or known is not objects:
            snapshot = self.copy()
            self._snapshot = snapshot.objects(), snapshot
        return snapshot

    def items(self) -> tuple[tuple[str, Obstacle, NDArray[np.float64]], ...]:
        """The name, the shape and T_base_object, shape (4, 4), of every object, as a snapshot.

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

    def show(self, *, size: tuple[int, int] | None = None, camera: str | ArrayLike | None = None) -> Recording:
        """A picture of the objects alone, drawn without a display; ``robot.show(q, world)`` also draws a robot.

        Args:
            size: Width and height [pixels]; 720 and 480 unless given.
            camera: Where they are seen from; see ``Robot.show``.

        Returns:
            A ``Recording``, which a notebook shows and keeps; its ``save("world.png")`` writes a file.

        Raises:
            InputError: The size or the camera is invalid.
            MissingExtraError: The extra ``viewer`` is not installed.
        """
        return drawer("world")(self, size=size, camera=camera)

    def objects(self) -> Objects:
        """A snapshot of the objects as tables for the kernels; only changes are laid out again."""
        cached = self._objects
        if cached is not None:
            return cached
        with self._lock:
            if self._objects is None:
                tables, self._tables = self._tables, None  # an interruption makes the next call lay out everything
                changed = dict.fromkeys(self._shapes, True) if tables is None else self._changed
                tables = tables or ObjectTables()
                objects = tables.updated(changed, self._shapes, self._poses, self._touch_links)
                objects.n_changes = self._n_changes
                if self._speeds:
                    objects.moving = tables.moving(self._speeds, self._update_numbers, self._poses)
                self._objects, self._tables, self._changed = objects, tables, {}
            return self._objects

    def changed_since(self, number: int) -> WorldState | None:
        """A snapshot of the objects, or None if nothing has changed since an earlier snapshot.

        Args:
            number: ``WorldState.number`` of the earlier snapshot; -1 if there is none.
        """
        with self._lock:
            if number == self._n_updates:
                return None
            return WorldState(self._n_updates, dict(self._shapes), dict(self._poses), dict(self._touch_links))

    def _mark_changed(self, name: str, *, pose_alone: bool = False) -> None:
        """Mark an object as changed, for the next layout and for a servo.

        This comes before the change, in case the change is interrupted. CPython handles a signal after a call, at the begin of a
        function and at the repeat of a loop. So a change calls no function between its first and its last store.
        """
        self._objects = None
        if not pose_alone or name not in self._changed:
            self._changed[name] = not pose_alone
        if not pose_alone or name not in self._speeds:
            self._n_changes += 1
        self._n_updates += 1

    def _exchange(self, removed: Collection[str], new: dict) -> None:
        """Remove objects, then add the contents of another world, which replace objects of the same names.

        The caller holds the lock.
        """
        names, contents = (*removed, *new["_shapes"]), self._contents()
        for name in names:
            self._mark_changed(name)
            for field in ("_touch_links", "_speeds", "_update_numbers") if name in new["_shapes"] else _CONTENTS:
                contents[field].pop(name, None)
        for field in _CONTENTS:
            contents[field].update(new[field])
        contents["_update_numbers"].update(dict.fromkeys(new["_speeds"], self._n_updates))
        self._shapes, self._poses, self._touch_links, self._speeds, self._update_numbers = (
            contents[field] for field in _CONTENTS
        )

    def _check_name(self, name: str) -> None:
        if not isinstance(name, str) or name not in self._shapes:
            raise UnknownNameError("object of the world", str(name), self._shapes)

    def __getstate__(self) -> dict:
        with self._lock:
            return self._contents()

    def _contents(self) -> dict:
        counts = {"_n_updates": self._n_updates, "_n_changes": self._n_changes}
        return {field: dict(getattr(self, field)) for field in _CONTENTS} | counts

    def __setstate__(self, state: dict) -> None:
        World.__init__(self)
        self.__dict__.update(state)

    def __repr__(self) -> str:
        with self._lock:
            shown = [f"{name!r} {type(shape).__name__}" for name, shape in list(self._shapes.items())[:_MAX_SHOWN]]
            count = len(self._shapes)
        rest = f" and {count - len(shown)} more" if count > len(shown) else ""
        return f"<World: {count or 'no'} object{'s' * (count != 1)}{': ' * bool(shown)}{', '.join(shown)}{rest}>"

    def _repr_html_(self) -> str:
        objects = self.items()
        rows = ((name, repr(shape), *T[:3, 3].tolist()) for name, shape, T in objects)
        sentence = f"World: {len(objects) or 'no'} object{'s' * (len(objects) != 1)}"
        return table(sentence, ("object", "shape", "x [m]", "y [m]", "z [m]"), rows)


def exchange(world: World, removed: Collection[str], new: World) -> None:
    """Remove objects of a world, and add those of another, replacing objects of the same names: all or none."""
    with world._lock:  # noqa: SLF001 - a function of this module, as users call no such method
        world._exchange([name for name in removed if name in world], new.__getstate__())  # noqa: SLF001


def refuse_no_world(world: object) -> None:
    """Raise an error for an argument that is neither a world nor None.

    Raises:
        InputError: It is of another type.
    """
    if world is not None and not isinstance(world, World):
        raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")


@cache
def _pose_copier() -> Callable[[ArrayLike], NDArray[np.float64]]:
    """``as_one_pose`` of the argument ``pose``: in C in a wheel, else in Python, where a compiler takes long to load."""
    in_python = partial(as_one_pose, name="pose")
    return bind(placing.copy_exact, "copy", (), 4, (4, 4), in_python) if IN_C else in_python


def _refuse_unsolid(name: str, shape: object) -> None:
    if not isinstance(shape, Obstacle):
        kind = type(shape).__name__
        makes = "ulna.ConvexMesh.from_points() makes a hull"
        if isinstance(shape, np.ndarray | list | tuple):
            makes = f"ulna.PointCloud(points, radius) makes a cloud of points, ulna.HeightMap(heights, cell) terrain, and {makes}"
        raise GeometryError(f"object {name!r} is a {kind}, which cannot be checked; {makes}")
