"""Reads and writes a world as a small JSON file, one object a line.

    {"ulna_scene": 1,
     "objects": [
      {"name": "crate", "shape": "box", "extents": [0.15, 0.09, 0.126], "xyz": [0.5, 0, 0.21], "rpy": [0, 0, 1.57]}
    ]}

Meters and radians, in the base frame of the robot; ``docs/viewer.md`` lists the shapes and their keys.
"""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import HeightMap, Obstacle, VoxelGrid
from ulna.collision.world import World
from ulna.description.file_bytes import file_bytes, json_value, write_whole
from ulna.description.pose import as_one_pose, pose, rpy_from_matrix
from ulna.description.shapes import KINDS, ConvexMesh, HalfSpace
from ulna.errors import DescriptionError, FileError, InputError, UlnaError, cited, did_you_mean, reason_of

VERSION = 1
LONGEST = 24_000_000  # bytes
SHAPES: dict[str, tuple[type, tuple[str, ...]]] = {
    **{kind.word: (kind.shape, tuple(kind.sizes)) for kind in KINDS},
    "convex_mesh": (ConvexMesh, ("vertices",)),
    "half_space": (HalfSpace, ()),
    "point_cloud": (PointCloud, ("points", "radius")),
    "height_map": (HeightMap, ("heights", "cell", "bottom")),
    "voxel_grid": (VoxelGrid, ("occupied", "cell", "corner")),
}
_TURNS = ("rpy", "wxyz", "rotation")  # roll, pitch, yaw; a quaternion; a matrix of three rows
_SHORTEST = (4, 6, 9, 12, 15, 17)  # decimals, tried in this order


def load_world(path: str | Path) -> World:
    """Read the world of a scene file.

    Raises:
        FileError: It cannot be read.
        InputError: ``path`` is not a path.
        DescriptionError: It is not a scene. The message names the file, the line or the object, and the nearest known word.
    """
    where = _as_path(path)
    try:
        content = file_bytes(where, LONGEST)
    except (OSError, ValueError) as error:
        raise FileError(str(path), reason_of(error)) from None
    return world_from_json(content, where.name)


def save_world(world: World, path: str | Path) -> None:
    """Write a world to a scene file. ``load_world`` restores it to the last digit.

    Raises:
        FileError: It cannot be written. An existing file stays unchanged.
        InputError: ``path`` is not a path, ``world`` is not a world, or its scene would be too large to load.
    """
    where = _as_path(path)
    if not isinstance(world, World):
        raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
    content = world_to_json(world).encode()
    try:
        write_whole(where, content)
    except (OSError, ValueError) as error:
        raise FileError(str(path), reason_of(error, missing="no such folder")) from None


def _as_path(path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)):
        raise InputError("path", f"{path!r}; a path is expected")
    return Path(path)  # type: ignore[arg-type]


def world_to_json(world: World) -> str:
    """The text of a scene file.

    Raises:
        InputError: It would be larger than ``load_world`` accepts.

    Example:
        >>> from ulna.description.shapes import Sphere
        >>> world = World()
        >>> world.add("ball", Sphere(0.1), pose((0.5, 0, 0.25)))
        >>> print(world_to_json(world), end="")
        {"ulna_scene": 1, "objects": [
          {"name": "ball", "shape": "sphere", "radius": 0.1, "xyz": [0.5, 0.0, 0.25]}
        ]}
    """
    still = world.copy()
    entries = (_entry(name, shape, T, still.touch_links(name), still.speed(name)) for name, shape, T in still.items())
    lines = ",\n".join(f"  {json.dumps(entry, ensure_ascii=False)}" for entry in entries)
    text = f'{{"ulna_scene": {VERSION}, "objects": [\n{lines}\n]}}\n'
    if len(text.encode()) > LONGEST:
        raise InputError("world", f"its scene has {len(text) / 1e6:.0f} MB; at most {LONGEST // 1_000_000} MB can be loaded")
    return text


def world_from_json(text: str | bytes, source: str = "scene") -> World:
    """The world of the text of a scene file; ``source`` names the file in messages.

    Raises:
        DescriptionError: It is not a scene. The message names the line or the object, and the nearest known word.
    """
    if len(text) > LONGEST:
        raise DescriptionError(f"more than {LONGEST // 1_000_000} MB, the maximum of a scene file", source)
    try:
        data = json_value(text, object_pairs_hook=_without_repeats, parse_constant=_no_number)
    except json.JSONDecodeError as error:
        raise DescriptionError(f"is not valid JSON: {error.msg} (column {error.colno})", source, error.lineno) from None
    except ValueError as error:
        raise DescriptionError(f"is not valid JSON: {error}", source) from None
    if not isinstance(data, dict) or not isinstance(data.get("objects"), list):
        raise DescriptionError('is not a scene: {"ulna_scene": 1, "objects": [...]} is expected', source)
    _refuse_unknown(data, ("ulna_scene", "objects"), "the scene", source)
    if data.get("ulna_scene") != VERSION:
        raise DescriptionError(f'"ulna_scene" is {cited(data.get("ulna_scene"))}; this version of Ulna reads {VERSION}', source)
    world = World()
    for number, entry in enumerate(data["objects"], start=1):
        _add(world, entry, number, source)
    return world


def _entry(
    name: str, shape: Obstacle, T: NDArray[np.float64], touch_links: frozenset[str], speed: float | None
) -> dict[str, Any]:
    word, (_, keys) = next((word, known) for word, known in SHAPES.items() if isinstance(shape, known[0]))
    sizes = {key: np.asarray(getattr(shape, key)).tolist() for key in keys}
    touching = {"touch_links": sorted(touch_links)} if touch_links else {}
    fastest = {} if speed is None else {"speed": speed}
    return {"name": name, "shape": word, **sizes, "xyz": T[:3, 3].tolist(), **_turn(T), **touching, **fastest}


def _turn(T: NDArray[np.float64]) -> dict[str, Any]:
    """The rotation as the shortest roll, pitch, yaw that restore every bit; else as a matrix."""
    if np.array_equal(T[:3, :3], np.eye(3)):
        return {}
    for digits in _SHORTEST:
        rpy = rpy_from_matrix(T).round(digits) + 0.0
        if np.array_equal(pose(rpy=rpy)[:3, :3], T[:3, :3]):
            return {"rpy": rpy.tolist()}
    return {"rotation": T[:3, :3].tolist()}


def _add(world: World, entry: Any, number: int, source: str) -> None:
    where = f"object {number}"
    if not isinstance(entry, dict):
        raise DescriptionError(f"{where} is {cited(entry):.60}; a JSON object is expected", source)
    name, word = entry.get("name"), entry.get("shape")
    if not isinstance(name, str) or not name:
        raise DescriptionError(f"{where} has no name; a text that is not empty is expected", source)
    where = f"{where} {cited(name)}"
    if not isinstance(word, str) or word not in SHAPES:
        raise DescriptionError(f"{where}: {cited(word)} is not a known shape{did_you_mean(str(word), SHAPES)}", source)
    kind, keys = SHAPES[word]
    _refuse_unknown(entry, ("name", "shape", *keys, "xyz", *_TURNS, "touch_links", "speed"), where, source)
    missing = [key for key in keys if key not in entry]
    if missing:
        raise DescriptionError(f"{where}: a {word} needs {missing[0]!r}", source)
    try:
        shape = kind(*(entry[key] for key in keys))
        world.add(name, shape, _pose(entry), touch_links=entry.get("touch_links", ()), speed=entry.get("speed"))
    except (UlnaError, TypeError) as error:
        raise DescriptionError(f"{where}: {error}", source) from None


def _pose(entry: dict[str, Any]) -> NDArray[np.float64]:
    turns = {key: entry[key] for key in _TURNS if key in entry}
    if len(turns) > 1:
        raise DescriptionError(f"{' and '.join(turns)} are given; one of them is enough")
    T = pose(entry.get("xyz", (0.0, 0.0, 0.0)), turns.get("rpy"), wxyz=turns.get("wxyz"))
    if "rotation" in turns:
        rotation = np.array(turns["rotation"], dtype=object)
        if rotation.shape != (3, 3):
            raise DescriptionError("rotation: three rows of three numbers are expected")
        T[:3, :3] = as_one_pose(np.block([[rotation, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]]).tolist())[:3, :3]
    return T


def _refuse_unknown(entry: dict[str, Any], known: tuple[str, ...], where: str, source: str) -> None:
    for key in entry:
        if key not in known:
            raise DescriptionError(f"{where}: key {cited(key)} is not known{did_you_mean(key, known)}", source)


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        seen: set[str] = set()
        repeated = next(key for key, _ in pairs if key in seen or seen.add(key))
        raise ValueError(f"key {cited(repeated)} is given twice in one object")
    return values


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a finite number")
