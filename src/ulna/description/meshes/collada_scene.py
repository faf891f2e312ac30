"""Walks the nodes of a Collada scene, and yields each instance of a geometry with its pose.

A node may be instanced many times, and so may the nodes within it: with forty levels, a file of 3 KB has 10^12 triangles. So the
instances are counted first, in one pass over the nodes.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.meshes.mesh_files import MAX_TRIANGLES
from ulna.description.pose import matrix_from_quaternion
from ulna.errors import count_of

Array = NDArray[np.float64]
_MAX_INSTANCES = 10_000
_DEEPEST = 64  # nested nodes
_NUMBERS = {"matrix": 16, "translate": 3, "scale": 3, "rotate": 4, "lookat": 9, "skew": 7}


class Scene:
    """The scene of a document."""

    def __init__(self, root: etree._Element) -> None:
        shown = [_target(one) for one in root.iterfind("{*}scene/{*}instance_visual_scene")]
        scenes = {scene.get("id"): scene for scene in root.iterfind("{*}library_visual_scenes/{*}visual_scene")}
        if len(shown) != 1 or shown[0] not in scenes:
            raise ValueError("it has no scene")
        self._nodes = {node.get("id"): node for node in root.iter("{*}node") if node.get("id") is not None}
        self._top = scenes[shown[0]].findall("{*}node")
        self._weights: dict[etree._Element, int] = {}
        instances = self._count(dict.fromkeys(self.urls(), 1), "instances of geometries", _MAX_INSTANCES)
        if not instances:
            raise ValueError("its scene shows no geometry")

    def urls(self) -> list[str]:
        """The ids of the geometries in the scene, each once."""
        found: dict[str, None] = {}
        seen: set[etree._Element] = set()
        rest = list(self._top)
        while rest:
            node = rest.pop()
            if node in seen:
                continue
            seen.add(node)
            if node.find("{*}instance_controller") is not None:
                raise ValueError("its scene shows a skin or a morph (instance_controller), which is not read")
            found |= dict.fromkeys(map(_target, node.iterfind("{*}instance_geometry")))
            rest += self._below(node)
        return list(found)

    def count_triangles(self, counts: Mapping[str, int]) -> int:
        """The triangles of all instances, from the count of each geometry."""
        return self._count(counts, "triangles", MAX_TRIANGLES)

    def placed(self) -> Iterator[tuple[Array, etree._Element]]:
        """Each instance of a geometry with its pose in the scene, shape (4, 4)."""
        for node in self._top:
            yield from self._placed(node, np.eye(4))

    def _placed(self, node: etree._Element, T: Array) -> Iterator[tuple[Array, etree._Element]]:
        if not self._weights[node]:
            return  # without geometry, such as a camera: its pose is not needed
        pose = T @ _transform(node)
        for instance in node.iterfind("{*}instance_geometry"):
            yield pose, instance
        for child in self._below(node):
            yield from self._placed(child, pose)

    def _below(self, node: etree._Element) -> list[etree._Element]:
        instances = [self._node(_target(one)) for one in node.iterfind("{*}instance_node")]
        return [*instances, *node.findall("{*}node")]

    def _node(self, name: str) -> etree._Element:
        if name not in self._nodes:
            raise ValueError(f"its scene shows the node {name!r}, which is not in the file")
        return self._nodes[name]

    def _count(self, counts: Mapping[str, int], what: str, most: int) -> int:
        self._weights = {}
        total = sum(self._weight(node, counts, 0) for node in self._top)
        if total > most:
            raise ValueError(f"its scene has {total} {what}; up to {most} are read")
        return total

    def _weight(self, node: etree._Element, counts: Mapping[str, int], depth: int) -> int:
        """The sum of a count over all geometries in and below a node."""
        if depth > _DEEPEST:
            raise ValueError("its scene is nested too deep, or refers to itself")
        if node not in self._weights:
            own = sum(counts.get(_target(one), 0) for one in node.iterfind("{*}instance_geometry"))
            self._weights[node] = own + sum(self._weight(child, counts, depth + 1) for child in self._below(node))
        return self._weights[node]


def _target(instance: etree._Element) -> str:
    url = instance.get("url", "")
    if not url.startswith("#"):
        raise ValueError(f"it refers to {url[:60]!r}, which is not in the file")
    return url[1:]


def _transform(node: etree._Element) -> Array:
    """The product of a node's transformations in their order, shape (4, 4)."""
    pose = np.eye(4)
    for element in node.iterchildren(etree.Element):
        tag = etree.QName(element).localname
        if tag in _NUMBERS:
            pose = pose @ _step(tag, element.text or "")
    return pose


def _step(tag: str, text: str) -> Array:
    values = np.array(text.split(), dtype=np.float64)
    if len(values) != _NUMBERS[tag] or not np.isfinite(values).all():
        raise ValueError(f"<{tag}> has {count_of(len(values), 'number')}; {_NUMBERS[tag]} finite are expected")
    step = np.eye(4)
    match tag:
        case "matrix":
            step = values.reshape(4, 4)
            if not np.array_equal(step[3], (0, 0, 0, 1)):
                raise ValueError("the last row of a <matrix> is not 0 0 0 1")
        case "translate":
            step[:3, 3] = values
        case "scale":
            step[:3, :3] = np.diag(values)
        case "rotate" if values[:3].any():
            half, axis = np.radians(values[3]) / 2, values[:3] / np.linalg.norm(values[:3])
            step[:3, :3] = matrix_from_quaternion([np.cos(half), *(np.sin(half) * axis)])
        case "lookat" | "skew":
            raise ValueError(f"a node with a geometry is placed by <{tag}>, which is not read")
    return step
