"""Makes a plain body for a robot without visuals: tubes from joint to joint, and housings."""

from collections.abc import Iterable, Iterator

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.geometry import align_vectors
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from ulna.description.robot_description import Joint, JointType
from ulna.robot import Robot

SHELL, HOUSING = (236, 238, 241, 255), (74, 82, 94, 255)  # the colours of the plain body: tubes, joints
_NARROWEST = 0.6  # the radius at the tip, as a part of that at the base


def plain_body(robot: Robot) -> dict[str, trimesh.Scene]:
    """A tube from each joint to the next, and a housing around each axis; thicker for a longer arm, thinner towards the tip."""
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
            scenes[link] = joined(parts)
    return scenes


def _taper(robot: Robot, link: str) -> float:
    """The factor of the radius of a link: from 1 at the base to _NARROWEST at the end of the longest chain."""
    depth = len(robot.tree.chain(link))
    deepest = max(len(robot.tree.chain(leaf)) for leaf in robot.tree.leaves)
    return 1.0 - (1.0 - _NARROWEST) * depth / deepest


def _housing(carrier: Joint | None, radius: float) -> list[trimesh.Trimesh]:
    """A foot for the root; for a link that a joint moves, a housing around its axis with a dark cap at each end."""
    if carrier is None:
        return [painted(trimesh.creation.cylinder(1.5 * radius, 0.4 * radius, sections=64), HOUSING)]
    if not _moves(carrier):
        return []
    turn = align_vectors([0, 0, 1], carrier.axis)
    return [
        painted(trimesh.creation.cylinder(1.15 * radius, 2.2 * radius, sections=64, transform=turn), SHELL),
        painted(trimesh.creation.cylinder(0.95 * radius, 2.45 * radius, sections=64, transform=turn), HOUSING),
    ]


def _moves(joint: Joint) -> bool:
    return joint.type != JointType.FIXED


def _tube(end: NDArray, radius: float) -> Iterator[trimesh.Trimesh]:
    """A tube with round ends from the origin to a point [m], shape (3,); none if the point is too near."""
    length = float(np.linalg.norm(end))
    if length > 0.2 * radius:
        yield painted(trimesh.creation.cylinder(radius, segment=[np.zeros(3), end], sections=48), SHELL)
        for centre in (np.zeros(3), end):
            ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
            yield painted(ball.apply_translation(centre), SHELL)


def painted(mesh: trimesh.Trimesh, rgba: tuple[int, ...]) -> trimesh.Trimesh:
    """Set one colour of the mesh, red, green, blue and opacity in 0..255, and return it."""
    mesh.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=rgba, metallicFactor=0.1, roughnessFactor=0.55))
    return mesh


def joined(parts: Iterable[trimesh.Trimesh | trimesh.Scene]) -> trimesh.Scene:
    """All parts in one scene."""
    scene = trimesh.Scene()
    for part in parts:
        for geometry in [part] if isinstance(part, trimesh.Trimesh) else part.dump():
            scene.add_geometry(geometry)
    return scene
