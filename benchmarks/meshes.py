"""``python -m benchmarks.meshes``: every mesh that robots of example-robot-data and rtb-data name, as Ulna and Assimp read it.

Coal loads them with Assimp. Compared are the bounds of the points that triangles use, and how many distinct points they are. A
table lists each file that differs. The tests (tests/crosscheck/test_mesh_points.py) do the same for a sample.
"""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import coal
import numpy as np

import ulna
from ulna.description.meshes.mesh_files import CHECKED, MeshFiles
from ulna.description.meshes.reader import mesh_bytes, read_scene, used_points
from ulna.description.shapes import Mesh
from ulna.errors import FileError, UlnaError
from ulna.robot import Robot

_TOLERANCE = 1e-5  # of the largest extent
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))


def main() -> None:
    """Print the table."""
    files: dict[Path, set[str]] = {}
    for robot in robots():
        for path in _meshes(robot):
            files.setdefault(path, set()).add(robot.name)
    rows = [(path, ", ".join(sorted(names)), row) for path, names in sorted(files.items()) if (row := _difference(path))]
    print(f"{len(files)} files, {len(rows)} differ\n\n| file | robots | how |\n|---|---|---|")
    for path, names, row in rows:
        print(f"| {path.parent.name}/{path.name} | {names} | {row} |")


def robots() -> Iterator[Robot]:
    """Those of both collections that can be loaded."""
    from robot_files import example_urdfs, rtb_package_dirs, rtb_xacros  # noqa: PLC0415 -- of the tests

    with tempfile.TemporaryDirectory() as links:
        for path in (*example_urdfs(), *rtb_xacros()):
            folders = rtb_package_dirs(Path(tempfile.mkdtemp(dir=links))) if path.suffix == ".xacro" else []
            try:
                yield ulna.load(path, package_dirs=folders)
            except UlnaError as error:
                print(f"{path.name}: {error}", file=sys.stderr)


def _meshes(robot: Robot) -> Iterator[Path]:
    files = MeshFiles(robot.description)
    for link in robot.description.links:
        for body in (*link.visuals, *link.collisions):
            if isinstance(body.shape, Mesh):
                try:
                    path = files.find(body.shape.uri).resolve()
                except FileError:
                    continue  # not in the collection
                if path.suffix.lower() in CHECKED:
                    yield path


def _difference(path: Path) -> str:
    """How the two differ; nothing if they do not."""
    try:
        found = used_points(read_scene(path, mesh_bytes(path)))
    except FileError as error:
        return error.message
    try:
        expected = coal.MeshLoader().load(str(path)).vertices()
    except (RuntimeError, ValueError) as error:
        return f"Assimp: {' '.join(str(error).split())[:80]}"
    bounds = [np.array([points.min(axis=0), points.max(axis=0)]) for points in (found, expected)]
    extents = [np.ptp(one, axis=0) for one in bounds]
    if np.abs(bounds[0] - bounds[1]).max() > _TOLERANCE * max(map(np.max, extents)):
        return f"extents {_numbers(extents[0])} m, Assimp {_numbers(extents[1])}"
    counts = [len(np.unique(points.astype(np.float32), axis=0)) for points in (found, expected)]
    return f"{counts[0]} points, Assimp {counts[1]}" if counts[0] != counts[1] else ""


def _numbers(values: np.ndarray) -> str:
    return " x ".join(f"{value:.4g}" for value in values)


if __name__ == "__main__":
    main()
