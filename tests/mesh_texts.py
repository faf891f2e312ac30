"""Writes a tetrahedron as a Collada, STL or OBJ file with given parts."""

CORNERS = "0 0 0 1 0 0 0 1 0 0 0 1"
FACES = "0 2 1 0 1 3 0 3 2 1 2 3"
ACCESSOR = (
    '<accessor source="#f" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>'
    '<param name="Z" type="float"/></accessor>'
)
INSTANCE = '<instance_geometry url="#g"/>'
TRIANGLES = f'<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{FACES}</p></triangles>'
SHOWN = '<scene><instance_visual_scene url="#V"/></scene>'


def collada(
    nodes=f"<node>{INSTANCE}</node>",
    *,
    asset="",
    array=CORNERS,
    accessor=ACCESSOR,
    primitives=TRIANGLES,
    libraries="",
    shown=SHOWN,
):
    source = f'<source id="s"><float_array id="f" count="{len(array.split())}">{array}</float_array>'
    source += f"<technique_common>{accessor}</technique_common></source>"
    vertices = '<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
    geometry = f'<library_geometries><geometry id="g"><mesh>{source}{vertices}{primitives}</mesh></geometry></library_geometries>'
    scene = f'<library_visual_scenes><visual_scene id="V">{nodes}</visual_scene></library_visual_scenes>'
    opening = '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
    return f"{opening}<asset>{asset}</asset>{geometry}{libraries}{scene}{shown}</COLLADA>"


def doubled(times):
    """A Collada file in which the tetrahedron is placed 2 ** times, by nodes that each show another twice."""
    nodes = "".join(
        f'<node id="n{k}"><instance_node url="#n{k + 1}"/><instance_node url="#n{k + 1}"/></node>' for k in range(times)
    )
    library = f'<library_nodes>{nodes}<node id="n{times}">{INSTANCE}</node></library_nodes>'
    return collada('<node><instance_node url="#n0"/></node>', libraries=library)


def stl(corners=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), name="part"):
    """An STL text of the four sides of a tetrahedron."""
    sides = ([corners[int(k)] for k in FACES.split()[i : i + 3]] for i in range(0, 12, 3))
    facets = "".join(
        "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in side) + "endloop\nendfacet\n"
        for side in sides
    )
    return f"solid {name}\n{facets}endsolid {name}\n"
