"""What a link looks like as triangles: the meshes and shapes of its description, or a plain body made from the kinematics."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.geometry import align_vectors
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from ulna.io.packages import resolve_uri
from ulna.model.convex_mesh import ConvexMesh
from ulna.model.description import Body, Joint, JointType
from ulna.model.shapes import Box, Capsule, Cylinder, Mesh, Sphere
from ulna.robot import Robot

SHELL, HOUSING = (236, 238, 241, 255), (74, 82, 94, 255)  # the colours of the plain body: tubes, joints
_NARROWEST = 0.6  # of the plain body's radius at the tip, against the base


def link_meshes(robot: Robot, package_dirs: Iterable[str | Path] = ()) -> dict[str, trimesh.Scene]:
    """For each link that shows anything its triangles, in the link's frame.

    If the description has no visuals, or a mesh of it is not on this machine, the whole robot gets a plain body.
    """
    try:
        own = {link.name: _scene(_visuals(link.visuals, package_dirs)) for link in robot.description.links if link.visuals}
    except FileNotFoundError:
        own = {}
    return own or plain_body(robot)


def plain_body(robot: Robot) -> dict[str, trimesh.Scene]:
    """A tube from each joint to the next and a housing about each axis, as thick as the arm is long, thinner to the tip."""
    joints = robot.description.joints
    carriers = {joint.child: joint for joint in joints}
    reach = sum(float(np.linalg.norm(joint.origin[:3, 3])) for joint in joints) or 1.0
    thickness = 0.055 * reach if robot.n_dof < 10 else 0.02 * reach
    scenes = {}
    for link in robot.link_names:
        radius = thickness * _taper(robot, link)
        parts = [
            part
            for joint in joints
            if joint.parent == link
            for part in _tube(joint.origin[:3, 3], radius * (0.8 if _moves(joint) else 0.5))
        ]
        parts += _housing(carriers.get(link), radius)
        if parts:
            scenes[link] = _scene(parts)
    return scenes


def _taper(robot: Robot, link: str) -> float:
    """From 1 at the base to _NARROWEST at the end of the longest chain."""
    depth = len(robot.tree.chain(link))
    deepest = max(len(robot.tree.chain(leaf)) for leaf in robot.tree.leaves)
    return 1.0 - (1.0 - _NARROWEST) * depth / deepest


def _housing(carrier: Joint | None, radius: float) -> list[trimesh.Trimesh]:
    """A foot for the root; for a link that a joint moves, a housing about its axis with a dark cap at each end."""
    if carrier is None:
        return [_painted(trimesh.creation.cylinder(1.5 * radius, 0.4 * radius, sections=64), HOUSING)]
    if not _moves(carrier):
        return []
    turn = align_vectors([0, 0, 1], carrier.axis)
    return [
        _painted(trimesh.creation.cylinder(1.15 * radius, 2.2 * radius, sections=64, transform=turn), SHELL),
        _painted(trimesh.creation.cylinder(0.95 * radius, 2.45 * radius, sections=64, transform=turn), HOUSING),
    ]


def _moves(joint: Joint) -> bool:
    return joint.type != JointType.FIXED


def _tube(end: NDArray, radius: float) -> Iterator[trimesh.Trimesh]:
    """A tube with round ends from the origin to a point, if there is room for one."""
    length = float(np.linalg.norm(end))
    if length > 0.2 * radius:
        yield _painted(trimesh.creation.cylinder(radius, segment=[np.zeros(3), end], sections=48), SHELL)
        for centre in (np.zeros(3), end):
            ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
            yield _painted(ball.apply_translation(centre), SHELL)


def _visuals(visuals: tuple[Body, ...], package_dirs: Iterable[str | Path]) -> Iterator[trimesh.Trimesh | trimesh.Scene]:
    for body in visuals:
        mesh = _triangles(body, package_dirs)
        if body.color is not None and isinstance(mesh, trimesh.Trimesh):
            _painted(mesh, tuple(round(255 * c) for c in body.color))
        mesh.apply_transform(body.pose)
        yield mesh


def _triangles(body: Body, package_dirs: Iterable[str | Path]) -> trimesh.Trimesh | trimesh.Scene:
    match body.shape:
        case Box(extents):
            return _painted(trimesh.creation.box(extents), SHELL)
        case Sphere(radius):
            return _painted(trimesh.creation.icosphere(subdivisions=3, radius=radius), SHELL)
        case Cylinder(radius, length):
            return _painted(trimesh.creation.cylinder(radius, length), SHELL)
        case Capsule(radius, length):
            return _painted(trimesh.creation.capsule(length, radius, transform=_down(length / 2)), SHELL)
        case ConvexMesh(vertices):
            return _painted(trimesh.PointCloud(vertices).convex_hull, SHELL)
        case Mesh(uri, scale):
            path, tried = resolve_uri(uri, None, package_dirs)
            if path is None:
                raise FileNotFoundError(f"{uri}; tried {', '.join(map(str, tried))}")
            scene = trimesh.load_scene(path)
            scene.apply_transform(np.diag([*scale, 1.0]))
            return scene


def _down(distance: float) -> NDArray:
    T = np.eye(4)
    T[2, 3] = -distance
    return T


def _painted(mesh: trimesh.Trimesh, rgba: tuple[int, ...]) -> trimesh.Trimesh:
    mesh.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=rgba, metallicFactor=0.1, roughnessFactor=0.55))
    return mesh


def _scene(parts: Iterable[trimesh.Trimesh | trimesh.Scene]) -> trimesh.Scene:
    scene = trimesh.Scene()
    for part in parts:
        for geometry in [part] if isinstance(part, trimesh.Trimesh) else part.dump():
            scene.add_geometry(geometry)
    return scene
