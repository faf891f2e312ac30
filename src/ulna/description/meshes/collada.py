"""Checks a Collada file and writes it with a flat scene: each instance of a geometry with one matrix.

Source: Collada 1.4.1 specification, chapters 4 and 5. As in RViz, the unit of the asset is applied and its ``up_axis`` is not,
since the URDF gives the orientation of the mesh. (Assimp applies both; Pinocchio and Coal, which read with Assimp, apply
neither.)
"""

from collections import defaultdict
from copy import deepcopy

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.meshes.collada_scene import Scene
from ulna.description.meshes.mesh_files import Rewritten
from ulna.errors import count_of

Array = NDArray[np.float64]
_TRIANGLES, _LINES = ("triangles", "polylist", "polygons"), ("lines", "linestrips")
_MATERIALS = ("library_materials", "library_effects", "library_images")


def rewritten_collada(data: bytes, *, materials: bool = True) -> Rewritten:
    """Its geometries and a flat scene in meters.

    Args:
        data: The file.
        materials: Whether to keep its materials, which may be invalid even if its geometries are valid.
    """
    root = _parsed(data)
    geometries = {geometry.get("id"): geometry for geometry in root.iterfind("{*}library_geometries/{*}geometry")}
    scene = Scene(root)
    counts = defaultdict(int)
    for url in scene.urls():
        geometry = geometries.get(url)
        if geometry is None:
            raise ValueError(f"its scene shows the geometry {url!r}, which is not in the file")
        counts[url] = _prepared(geometry)
    meters, n_triangles = _meters(root), scene.count_triangles(counts)
    nodes = [(meters @ T, instance) for T, instance in scene.placed()]
    kept = ("asset", "library_geometries", *(_MATERIALS if materials else ()))
    for part in root.iterchildren(etree.Element):
        if etree.QName(part).localname not in kept:
            root.remove(part)
    if not materials:
        for _, instance in nodes:
            del instance[:]
    _add_flat_scene(root, nodes)
    return Rewritten(etree.tostring(root), n_triangles)


def _parsed(data: bytes) -> etree._Element:
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, remove_comments=True, remove_pis=True
    )
    root = etree.fromstring(data, parser)
    if root.getroottree().docinfo.internalDTD is not None:
        raise ValueError("it declares a document type, which a mesh does not need")
    if etree.QName(root).localname != "COLLADA":
        raise ValueError("it is not a Collada file")
    return root


def _meters(root: etree._Element) -> Array:
    unit = root.find("{*}asset/{*}unit")
    meters = float(unit.get("meter", "1")) if unit is not None else 1.0
    if not 0 < meters < np.inf:
        raise ValueError(f"its unit is {meters:g} m; a length above 0 is expected")
    return np.diag([meters, meters, meters, 1.0])


def _prepared(geometry: etree._Element) -> int:
    """The number of triangles of a geometry; rewrites its sources without strides."""
    mesh = geometry.find("{*}mesh")
    if mesh is None:
        raise ValueError(f"its geometry {geometry.get('id')!r} is not a mesh of polygons")
    for source in mesh.iterfind("{*}source"):
        _make_dense(source)
    count = 0
    for primitive in mesh.iterchildren(etree.Element):
        kind = etree.QName(primitive).localname
        if kind in _TRIANGLES:
            count += _n_triangles(primitive, kind)
        elif kind not in ("source", "vertices", "extra", *_LINES):
            raise ValueError(f"its geometry {geometry.get('id')!r} has {kind}, which are not read")
    return count


def _n_triangles(primitive: etree._Element, kind: str) -> int:
    """The number of triangles of one group, with each polygon split into a fan."""
    if primitive.find("{*}ph") is not None:
        raise ValueError("it has polygons with holes, which are not read")
    if kind == "polylist":
        return sum(max(0, int(n) - 2) for n in _words(primitive.find("{*}vcount")))
    inputs = primitive.findall("{*}input")
    width = 1 + max((int(one.get("offset", "0")) for one in inputs), default=0)
    lists = [len(_words(p)) // width for p in primitive.iterfind("{*}p")]
    if kind == "polygons":
        return sum(max(0, n - 2) for n in lists)
    if len(lists) > 1:
        raise ValueError("it has triangles with several lists of indices")
    return sum(lists) // 3


def _words(element: etree._Element | None) -> list[str]:
    return [] if element is None or element.text is None else element.text.split()


def _make_dense(source: etree._Element) -> None:
    """Write an array as its accessor reads it: from an offset, in strides, without unnamed parameters."""
    array, accessor = source.find("{*}float_array"), source.find("{*}technique_common/{*}accessor")
    if array is None or accessor is None:
        return  # an array of names, or a source that pycollada refuses
    try:
        values = np.array(_words(array), dtype=np.float64)
    except ValueError:
        raise ValueError(f"the array {array.get('id')!r} has words that are not numbers") from None
    if not np.isfinite(values).all():
        raise ValueError(f"the array {array.get('id')!r} has numbers that are not finite")
    params = accessor.findall("{*}param")
    stride, offset, count = (
        int(accessor.get(key, default)) for key, default in (("stride", "1"), ("offset", "0"), ("count", "0"))
    )
    named = [k for k, param in enumerate(params) if param.get("name")] or list(range(len(params)))
    if accessor.get("source", "").removeprefix("#") != array.get("id"):
        raise ValueError(f"the source {source.get('id')!r} reads an array that is not its own")
    if stride == len(params) == len(named) and offset == 0 and count * stride == len(values):
        return
    n_beyond = offset + count * stride - (len(values) + stride - len(params))
    if stride < max(1, len(params)) or min(offset, count) < 0 or n_beyond > 0:
        raise ValueError(f"the source {source.get('id')!r} reads beyond its array of {count_of(len(values), 'number')}")
    rows = offset + stride * np.arange(count)[:, None] + np.array(named, dtype=int)
    array.text = " ".join(map(repr, values[rows].ravel().tolist()))
    array.set("count", str(rows.size))
    for param in [param for k, param in enumerate(params) if k not in named]:
        accessor.remove(param)
    accessor.set("stride", str(len(named)))
    accessor.set("offset", "0")


def _add_flat_scene(root: etree._Element, nodes: list[tuple[Array, etree._Element]]) -> None:
    namespace = etree.QName(root).namespace

    def add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
        return etree.SubElement(parent, tag if namespace is None else f"{{{namespace}}}{tag}", attributes)

    flat = add(add(root, "library_visual_scenes"), "visual_scene", id="ulna-flat")
    for k, (T, instance) in enumerate(nodes):
        node = add(flat, "node", id=f"ulna-{k}")
        add(node, "matrix").text = " ".join(map(repr, T.ravel().tolist()))
        node.append(deepcopy(instance))
    add(add(root, "scene"), "instance_visual_scene", url="#ulna-flat")
