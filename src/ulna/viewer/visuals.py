"""Makes the triangles of links and shapes: meshes with their materials, primitive shapes, or a drawn body."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.gltf import export_glb
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import HeightMap, VoxelGrid
from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.meshes.mesh_files import MeshFiles
from ulna.description.meshes.reader import NeighborFiles, mesh_bytes, read_scene
from ulna.description.robot_description import Body
from ulna.description.shapes import ConvexMesh, Mesh, Primitive, UnknownShape
from ulna.errors import FileError
from ulna.robot import Robot
from ulna.viewer.drawn_body import SHELL, drawn_body, merge_parts, paint_mesh
from ulna.viewer.palette import Color
from ulna.viewer.panda_meshes import packaged_mesh, read_packaged
from ulna.viewer.primitives import primitive_triangles

Drawn = Primitive | ConvexMesh | PointCloud | HeightMap | VoxelGrid
"""Shapes of obstacles that have triangles."""
_ROUGH = 0.35  # of a material that states no roughness: shells have highlights


@dataclass(frozen=True, eq=False)
class Visuals:
    """The visuals of a robot.

    Attributes:
        scenes: The visuals of each link, in its own frame.
        missing: The meshes that could not be read, each with the reason.
    """

    scenes: dict[str, trimesh.Scene]
    missing: tuple[str, ...] = ()


def link_visuals(robot: Robot) -> Visuals:
    """The visuals of a robot.

    A link with a missing mesh gets a drawn body. All links get one if none has visuals.
    """
    files, scenes, missing = MeshFiles(robot.description), {}, {}
    for link in robot.description.links:
        try:
            scenes[link.name] = merge_parts(_colored(body, files) for body in link.visuals)
        except FileError as error:
            missing[str(error)] = link.name
    if missing or not any(scene.geometry for scene in scenes.values()):
        drawn, bare = drawn_body(robot), set(missing.values()) or set(scenes)
        scenes |= {name: scene for name, scene in drawn.items() if name in bare}
    return Visuals({name: scene for name, scene in scenes.items() if scene.geometry}, tuple(missing))


def links_moving_with(robot: Robot, links: Iterable[str]) -> frozenset[str]:
    """Some links, and the links that fixed joints connect to them."""
    rows = robot.tree.link_row
    bodies = {rows[link] for link in links}
    return frozenset(link for link in robot.link_names if rows[link] in bodies)


def touching_links(robot: Robot, report: Report) -> frozenset[str]:
    """The links in contact, and the links that fixed joints connect to them."""
    hits = [pair for pair in report.pairs if pair.signed_distance <= 0.0]
    ends = (link for pair in hits for link in (pair.link_a, pair.link_b))
    return links_moving_with(robot, [link for link in ends if link is not None])


def read_mesh(mesh: Mesh, files: MeshFiles) -> trimesh.Scene:
    """The scaled triangles of a mesh file with their materials; collision checking uses the same triangles."""
    try:
        path = files.find(mesh.uri)
    except FileError:
        if (path := packaged_mesh(mesh.uri)) is None:
            raise
        scene = read_packaged(path)
    else:
        scene = read_scene(path, mesh_bytes(path), NeighborFiles(files, path))
    for geometry in scene.geometry.values():
        if isinstance(geometry, trimesh.Trimesh):
            geometry.merge_vertices()  # for smooth shading
    return scene.apply_transform(np.diag([*mesh.scale, 1.0]))


def glb_of(scene: trimesh.Scene) -> bytes:
    """A scene as a binary glTF file for the page. Its sRGB colors become linear light, as glTF requires."""
    before = {name: mesh.visual for name, mesh in scene.geometry.items() if isinstance(mesh, trimesh.Trimesh)}
    for name, visual in before.items():
        if isinstance(visual, TextureVisuals) and (material := _in_linear_light(visual.material)) is not None:
            scene.geometry[name].visual = TextureVisuals(uv=visual.uv, material=material)
    try:
        return export_glb(scene)
    finally:
        for name, visual in before.items():
            scene.geometry[name].visual = visual


def tinted(scene: trimesh.Scene, color: Color, share: float) -> trimesh.Scene:
    """A copy of a scene with one color per mesh: its own color, mixed with a share of another one."""
    meshes = [mesh.copy() for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    for mesh in meshes:
        visual: Any = mesh.visual
        own = visual.material.main_color if hasattr(visual, "material") else visual.main_color
        mixed = (1.0 - share) * np.asarray(own[:3], dtype=np.float64) + share * np.asarray(color)
        paint_mesh(mesh, (*mixed.round().astype(int).tolist(), 255))
    return trimesh.Scene(meshes)


def _in_linear_light(material: Any) -> PBRMaterial | None:
    """A material without a texture, with its color in linear light; None for one with a texture."""
    pbr = material if isinstance(material, PBRMaterial) else material.to_pbr()
    if pbr.baseColorTexture is not None:
        return None
    rgba = np.asarray(material.main_color, dtype=np.float64) / 255.0
    light = np.where(rgba <= 0.04045, rgba / 12.92, ((rgba + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    rough = _ROUGH if pbr.roughnessFactor is None else pbr.roughnessFactor
    return PBRMaterial(baseColorFactor=[*light[:3], rgba[3]], metallicFactor=0.0, roughnessFactor=rough, alphaMode=pbr.alphaMode)


def triangles(shape: Drawn) -> trimesh.Trimesh:
    """The triangles of a shape in its own frame; ``read_mesh`` is for mesh files."""
    match shape:
        case ConvexMesh(vertices):
            return _hull(vertices)
        case PointCloud() | HeightMap() | VoxelGrid():
            return _point_triangles(shape)
        case _:
            return primitive_triangles(shape)


def outlines_near(world: World, center: NDArray[np.float64], reach: float, kinds: Any = Drawn) -> list[NDArray[np.float64]]:
    """The vertices of each obstacle of some kinds near a point, shape (n, 3) each, in the base frame [m].

    Args:
        world: The obstacles. A half-space has no vertices.
        center: The point [m], shape (3,).
        reach: An obstacle is near if each of its coordinates differs from the point's by at most this [m]; infinite for all.
        kinds: The classes of their shapes.
    """
    shapes: list[tuple[Any, NDArray[np.float64]]] = [(shape, T) for _, shape, T in world.items() if isinstance(shape, kinds)]
    outlines = [triangles(shape).vertices @ T[:3, :3].T + T[:3, 3] for shape, T in shapes]
    return [points for points in outlines if np.abs(points - center).max() <= reach]


def _colored(body: Body, files: MeshFiles) -> trimesh.Scene:
    """A visual in the frame of its link. A mesh without a material gets the color of the description."""
    rgba = SHELL if body.color is None else tuple(round(255 * share) for share in body.color)
    if isinstance(body.shape, Mesh):
        scene = read_mesh(body.shape, files)
        for mesh in scene.geometry.values():
            if isinstance(mesh, trimesh.Trimesh) and not (mesh.visual and mesh.visual.defined):
                paint_mesh(mesh, rgba)
    elif isinstance(body.shape, UnknownShape):
        scene = trimesh.Scene()
    else:
        scene = trimesh.Scene(paint_mesh(triangles(body.shape), rgba))
    scene.apply_transform(body.pose)
    return scene


def _hull(vertices: NDArray[np.float64]) -> trimesh.Trimesh:
    """The convex hull of vertices; without a volume or without SciPy, a ball at each vertex."""
    try:
        return trimesh.convex.convex_hull(vertices)
    except (ImportError, ValueError, RuntimeError):  # Qhull's own error is a RuntimeError
        radius = 0.02 * max(float(np.ptp(vertices, axis=0).max()), 0.05)
        balls = [trimesh.creation.icosphere(subdivisions=1, radius=radius).apply_translation(point) for point in vertices]
        return trimesh.util.concatenate(balls)  # type: ignore[return-value]


def _point_triangles(shape: PointCloud | HeightMap | VoxelGrid) -> trimesh.Trimesh:
    """The triangles of a point cloud or grid: a coarse ball at each point, or a box for each cell."""
    if isinstance(shape, PointCloud):
        one, places, sizes = trimesh.creation.icosphere(subdivisions=0), shape.points, np.full((1, 3), shape.radius)
    else:
        one, (places, sizes) = trimesh.creation.box((2, 2, 2)), shape.boxes
    vertices = places[:, None] + sizes[:, None] * one.vertices
    faces = len(one.vertices) * np.arange(len(vertices))[:, None, None] + one.faces
    return trimesh.Trimesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), process=False)
