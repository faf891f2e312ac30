"""Reads one hostile file of each format and size within 1 GB of address space, and prints each result.

    python tests/hostile_files.py FOLDER

The files are small, or of 1 MB. They state, repeat or nest more than they contain. A fork of this process, which has imported all
modules, reads each of them.
"""

# ruff: noqa: E501, PLW0108, T201

import base64
import json
import os
import pickle
import struct
import sys
import time
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path

MEMORY = 1_000_000_000  # bytes of address space
SECONDS = 5  # of the processor, for one file
MB = 1_000_000
XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}<link name="a"/></robot>'


def glb(tree: dict, binary: bytes = b"") -> bytes:
    text = json.dumps(
        {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], **tree}
    ).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def accessor(count: int, kind: str = "VEC3", **more) -> dict:
    return {"componentType": 5126, "count": count, "type": kind, **more}


def zeros_glb(count: int) -> bytes:
    return glb({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [accessor(count)], "bufferViews": []})


def shared_glb(n: int) -> bytes:
    """Many primitives of the same points."""
    points = bytes(12 * 30_000)
    tree = {"buffers": [{"byteLength": len(points)}], "bufferViews": [{"buffer": 0, "byteLength": len(points)}]}
    tree |= {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * n}], "accessors": [accessor(30_000, bufferView=0)]}
    return glb(tree, points)


def npy(shape: tuple, kind: str = "<f8", body: bytes = b"") -> bytes:
    head = str({"descr": kind, "fortran_order": False, "shape": shape}).encode()
    head += b" " * ((-len(head) - 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + body


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = zlib.compress(bytes(min(width * height // 8, 50 * MB)))
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows[: MB // 2]) + chunk(b"IEND", b"")


def ply(*elements: str, kind: str = "ascii", body: bytes = b"") -> bytes:
    return "\n".join(["ply", f"format {kind} 1.0", *elements, "end_header", ""]).encode() + body


def pcd(n: int, fields: str = "x y z", body: bytes = b"", form: str = "binary") -> bytes:
    m = len(fields.split())
    return f"FIELDS {fields}\nSIZE{' 4' * m}\nTYPE{' F' * m}\nPOINTS {n}\nDATA {form}\n".encode() + body


def collada(vertices: str, accessor: str, triangles: str = "", nodes: str = '<instance_geometry url="#g"/>') -> bytes:
    mesh = f"""<source id="s"><float_array id="f">{vertices}</float_array><technique_common><accessor source="#f" {accessor}>
    <param name="X"/><param name="Y"/><param name="Z"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{triangles}"""
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_geometries><geometry id="g"><mesh>
    {mesh}</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="v1"><node id="n0">{nodes}</node>
    </visual_scene></library_visual_scenes><scene><instance_visual_scene url="#v1"/></scene></COLLADA>""".encode()


def scene(objects: str) -> bytes:
    return f'{{"ulna_scene": 1, "objects": [{objects}]}}'.encode()


def limits(joint: str, head: str = "") -> bytes:
    return f"{head}joint_limits:\n  panda_joint1: {joint}\n".encode()


def bomb(levels: int) -> str:
    """YAML of nested aliases, each of which is ten of those before."""
    lines = ["a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n"]
    lines += [f"a{k}: &a{k} [{','.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, levels + 1)]
    return "".join(lines)


def nested(begin: str, end: str, n: int) -> str:
    return begin * n + end * n


def sdf(parts: str, version: str = "1.9") -> bytes:
    return f'<sdf version="{version}"><model name="m">{parts}</model></sdf>'.encode()


TRIANGLE = '<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>'
VERTEX = ("element vertex {}", "property float x", "property float y", "property float z")
FACE = ("element face {}", "property list uchar int vertex_indices")
BALL = '{{"name": "{}", "shape": "sphere", "radius": {}}}'
FILES: dict[str, Callable[[], bytes]] = {
    "robot.urdf deep": lambda: nested("<a>", "</a>", 140).encode(),
    "robot.urdf numbers": lambda: ('<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed"><origin xyz="' + "9" * MB + '"/></joint></robot>').encode(),
    "robot.urdf names": lambda: ("<robot " + " ".join(f'a{k}="{k}"' for k in range(60_000)) + "/>").encode(),
    "robot.urdf entities": lambda: b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><robot name="&b;"/>',
    "robot.urdf links": lambda: ('<robot name="r">' + '<link name="l"/>' * 60_000 + "</robot>").encode(),
    "robot.sdf deep": lambda: nested("<a>", "</a>", 140).encode(),
    "robot.sdf models": lambda: sdf("".join(f'<model name="m{k}">' for k in range(120)) + "</model>" * 120),
    "robot.sdf scopes": lambda: sdf("".join(f'<model name="{"n" * 300}">' for _ in range(5)) + "<link/>" * 100_000 + "</model>" * 5),
    "robot.sdf numbers": lambda: sdf(f'<link name="a"><pose>{"9" * MB}</pose></link>'),
    "robot.sdf version": lambda: sdf('<link name="a"/>', "9" * MB),
    "robot.sdf names": lambda: ("<sdf " + " ".join(f'a{k}="{k}"' for k in range(60_000)) + "/>").encode(),
    "robot.sdf name": lambda: sdf(f'<link name="{"n" * MB}"/>'),
    "robot.sdf entities": lambda: b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><sdf version="1.9"><model name="&b;"/></sdf>',
    "robot.sdf links": lambda: sdf('<link name="l"/>' * 60_000),
    "robot.sdf frames": lambda: sdf('<link name="l"/>' + "".join(f'<frame name="f{k}" attached_to="f{k + 1}"/>' for k in range(24_000))),
    "robot.sdf circle": lambda: sdf('<link name="l"/>' + "".join(f'<frame name="f{k}" attached_to="f{(k + 1) % 24_000}"/>' for k in range(24_000))),
    "robot.sdf poses": lambda: sdf("".join(f'<link name="l{k}"><pose relative_to="l{k + 1}">1 0 0 1 1 1</pose></link>' for k in range(8_000))),
    "robot.sdf unread": lambda: sdf("<a/>" * 240_000),
    "robot.sdf attributes": lambda: sdf("<link " + " ".join(f'a{k}=""' for k in range(90_000)) + "/>"),
    "robot.sdf joint": lambda: sdf(f'<link name="a"/><joint name="j" type="{"t" * MB}"/>'),
    "robot.sdf address": lambda: sdf(f'<link name="a"/><include><uri>model://{"u" * MB}</uri></include>'),
    "robot.sdf itself": lambda: sdf('<link name="a"/>' + "<include><uri>robot.sdf</uri></include>" * 20_000),
    "robot.sdf world": lambda: b'<sdf version="1.9"><world name="w">' + b"<include><uri>model://a</uri></include>" * 24_000 + b"</world></sdf>",
    "robot.sdf worlds": lambda: b'<sdf version="1.9"><world name="w">' + b'<model name="m"/>' * 55_000 + b"</world></sdf>",
    "arm.srdf deep": lambda: nested("<group>", "</group>", 60_000).encode(),
    "arm.srdf groups": lambda: ('<robot name="panda">' + '<group name="g"/>' * 50_000 + "</robot>").encode(),
    "arm.srdf value": lambda: ('<robot name="panda"><group_state name="s" group="g"><joint name="j" value="' + "1e999 " * 150_000 + '"/></group_state></robot>').encode(),
    "arm.srdf small": lambda: b'<robot name="panda"><group name="' + b"x" * 900 + b'"><chain base_link="a"/></group></robot>',
    "robot.xacro memory": lambda: XACRO.format('<link name="${\'x\' * 10**9 * 4}"/>').encode(),
    "robot.xacro message": lambda: XACRO.format("<link name=\"${xacro.fatal('x' * 300000000)}\"/>").encode(),
    "robot.xacro wide": lambda: XACRO.format(f"<link name=\"${{'{'x' * 900_000}' * 100}}\"/>").encode(),
    "mesh.stl": lambda: bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50),
    "mesh.stl text": lambda: b"solid x\n" + b"facet normal 0 0 1 " * 50_000,
    "mesh.obj": lambda: b"v 0 0 0\nf 1 2 " + b"9" * 900,
    "mesh.obj words": lambda: b"v 0 0 0\n" + b"f 9999999999 2 3\n" * 58_000,
    "mesh.dae count": lambda: collada("", 'count="1000000000" stride="0"', TRIANGLE.replace("0 1 2", "")),
    "mesh.dae instances": lambda: collada("0 0 0 1 0 0 0 1 0", 'count="3" stride="3"', TRIANGLE, "".join('<node id="m">' for _ in range(300)) + "</node>" * 300),
    "mesh.dae numbers": lambda: collada("1 " * 480_000, 'count="999999999999" stride="3"', TRIANGLE),
    "mesh.glb zeros": lambda: zeros_glb(10**9),
    "mesh.glb shared": lambda: shared_glb(15_000),
    "mesh.glb cycle": lambda: glb({"nodes": [{"children": [1]}, {"children": [0]}]}),
    "mesh.glb deep": lambda: glb({"nodes": [{"children": [k + 1]} for k in range(9_000)] + [{}]}),
    "mesh.gltf views": lambda: json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 600_000, "uri": "data:;base64," + base64.b64encode(bytes(600_000)).decode()}], "bufferViews": [{"buffer": 0, "byteLength": 600_000}] * 4_000, "accessors": []}).encode(),
    "mesh.gltf levels": lambda: b"[" * 900,
    "mesh.ply lie": lambda: ply(*(one.format(10**11) for one in VERTEX), kind="binary_little_endian", body=bytes(24)),
    "mesh.ply faces": lambda: ply(*(one.format(1) for one in VERTEX), *(one.format(490_000) for one in FACE), body=b"0 0 0\n" + b"0\n" * 480_000),
    "mesh.off lie": lambda: b"OFF\n999999999999 999999999999 0\n0 0 0\n",
    "mesh.off lines": lambda: b"OFF\n3 300000 0\n0 0 0\n1 0 0\n0 1 0\n" + b"9\n" * 490_000,
    "cloud.npy lie": lambda: npy((10**9, 3), body=bytes(24)),
    "cloud.npy objects": lambda: npy((1, 3), "|O", pickle.dumps([1, 2, 3])),
    "cloud.npy nothing": lambda: npy((3, 3, 10**6, 10**6), "|V0"),
    "cloud.npy head": lambda: b"\x93NUMPY\x02\x00" + struct.pack("<I", MB) + b"(" * MB,
    "cloud.npy nested": lambda: b"\x93NUMPY\x01\x00" + struct.pack("<H", 900) + b"(" * 900,
    "cloud.csv": lambda: b"," * MB,
    "cloud.xyz lines": lambda: b"\n" * MB,
    "cloud.xyz words": lambda: b"1 2\n" * 225,
    "cloud.xyz long": lambda: b"9" * MB,
    "cloud.ply properties": lambda: ply("element vertex 1", *(f"property float p{k}" for k in range(45_000)), body=b"0 0 0\n"),
    "cloud.ply elements": lambda: ply(*(f"element e{k} 0" for k in range(40))),
    "cloud.ply list": lambda: ply(*(one.format(1) for one in VERTEX), *(one.format(10**9) for one in FACE), kind="binary_big_endian", body=bytes(900_000)),
    "cloud.pcd fields": lambda: pcd(1, "x y z" + " a" * 160_000),
    "cloud.pcd lie": lambda: pcd(10**12, body=bytes(12)),
    "cloud.pcd counts": lambda: pcd(1).replace(b"TYPE", b"COUNT 999999999999 1 1\nTYPE"),
    "world.json keys": lambda: ("{" + ",".join(f'"{k:x}":0' for k in range(90_000)) + ',"0":0}').encode(),
    "world.json levels": lambda: b"[" * 900,
    "world.json lists": lambda: scene("[]," * 300_000 + "[]"),
    "world.json digits": lambda: scene(BALL.format("a", "9" * 900)),
    "world.json exponent": lambda: scene(BALL.format("a", "1e" + "9" * 900)),
    "world.json name": lambda: scene(BALL.format("n" * MB, '"x"')),
    "world.json twice": lambda: scene(",".join([BALL.format("a", 1)] * 25_000)),
    "world.json cells": lambda: scene('{"name": "h", "shape": "height_map", "cell": 1e-9, "bottom": -1e308, "heights": [[' + "1e308," * 150_000 + "1]]}"),
    "world.json voxels": lambda: scene('{"name": "v", "shape": "voxel_grid", "cell": 1e300, "corner": [0, 0, 0], "occupied": [[[' + "1," * 490_000 + "1]]]}"),
    "world.json ragged": lambda: scene('{"name": "m", "shape": "point_cloud", "radius": 1, "points": [' + "[0]," * 240_000 + "[0,0,0]]}"),
    "limits.yaml aliases": lambda: limits("{max_velocity: *a7}", bomb(7)),
    "limits.yaml base 60": lambda: limits("{max_velocity: 1" + ":1" * 490_000 + "}"),
    "limits.yaml digits": lambda: limits("{max_velocity: 0x" + "f" * 900 + "}"),
    "limits.yaml commas": lambda: limits("[x" + ",x" * 490_000 + "]"),
    "limits.yaml levels": lambda: limits("[" * 490_000),
    "limits.yaml itself": lambda: limits("&a {max_velocity: *a}"),
    **{f"limits.yaml {tag}": lambda tag=tag: limits(f"{{max_velocity: {tag} x }}") for tag in ("!!set", "!!omap", "!!pairs", "!!binary", "!!timestamp", "!!python/name:os.system", "!!bool", "!!int", "!!float", "!degrees", "!x")},
    "motion.csv long": lambda: b"0,0,0,0,0,0,0,0\n100000,1,1,1,1,1,1,1\n",
    "motion.csv words": lambda: b"1," * 490_000,
    "motion.npy lie": lambda: npy((10**9, 8), body=bytes(64)),
    "motion.npy objects": lambda: npy((2, 8), "|O", pickle.dumps(1)),
    "rows.csv lines": lambda: b"1\n" * 490_000,
    "rows.npy lie": lambda: npy((2**62, 7)),
    "poses.csv digits": lambda: b"9" * 5_000 + b",0,0,0,0,0\n",
    "poses.npy lie": lambda: npy((10**8, 4, 4), "<f4", bytes(64)),
    "texture.png": lambda: png(16_000, 16_000),
    "map.zarr values": lambda: (b'{"attributes": {"a": [' + b"[]," * 320_000 + b"[]]}}"),
    "map.zarr levels": lambda: b'{"attributes": ' + b"[" * 900,
    "map.zarr grid": lambda: json.dumps({"attributes": {"ulna_reachability_map": 2, "voxels_zyx": [2**20, 2**20, 2**20], "low": [0, 0, 0], "voxel": 1e-9, "orientations": 1 << 40, "chunk_poses": 1 << 40, "task": "{}", "robot": "r"}}).encode(),
}  # fmt: skip


def readers() -> dict[str, Callable[[Path], object]]:
    """What reads a file, by its name."""
    import ulna
    from ulna.cli import rows
    from ulna.description.meshes import reader
    from ulna.reachability.map import ReachabilityMap
    from ulna.viewer.uploads import shapes_of_file

    panda = ulna.load("panda")
    panda.in_collision(panda.home, ulna.World())  # loads what a question needs

    def as_visual(path: Path) -> object:
        return reader.read_scene(path, reader.mesh_bytes(path), reader.NeighborFiles(reader.MeshFiles(panda.description), path))

    def as_cloud(path: Path) -> object:
        ulna.PointCloud.from_file(path, radius=0.01)
        return shapes_of_file(path.name, path.read_bytes())

    def with_texture(path: Path) -> object:
        """A mesh whose material is the image; the mesh itself is read without it."""
        path.with_name("m.mtl").write_text(f"newmtl m\nmap_Kd {path.name}\n")
        mesh = path.with_name("m.obj")
        mesh.write_text("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n")
        read = as_visual(mesh)
        image = getattr(next(iter(read.geometry.values())).visual.material, "image", None)  # type: ignore[attr-defined]
        raise ulna.FileError(path.name, "left out" if image is None else f"kept, with {image.size}")

    def as_map(path: Path) -> object:
        folder = path.with_name("map")
        folder.mkdir()
        path.rename(folder / "zarr.json")
        return ReachabilityMap.open(folder).summary

    return {
        ".urdf": ulna.load, ".sdf": ulna.load, ".xacro": ulna.load, ".srdf": lambda path: ulna.load("panda", srdf=path),
        **dict.fromkeys((".stl", ".obj", ".dae", ".glb", ".gltf", ".off"), as_visual), ".json": ulna.load_world,
        **dict.fromkeys((".npy", ".csv", ".xyz", ".ply", ".pcd"), as_cloud), "mesh.ply": as_visual,
        ".yaml": lambda path: panda.trajectory([panda.home, panda.home + 0.1], limits=path, acceleration=1.0),
        **dict.fromkeys(("motion.csv", "motion.npy"), lambda path: rows.read_motion(path, panda)),
        **dict.fromkeys(("rows.csv", "rows.npy"), lambda path: rows.read_trajectory(path, panda)),
        **dict.fromkeys(("poses.csv", "poses.npy"), rows.read_poses), ".png": with_texture, ".zarr": as_map,
    }  # fmt: skip


def outcome(read: Callable[[Path], object], path: Path) -> dict[str, object]:
    """What came of reading a file, with the error that it raised."""
    import resource

    from ulna import UlnaError

    warnings.simplefilter("ignore")
    begin = time.process_time()
    try:
        read(path)
    except Exception as error:  # noqa: BLE001 - whatever it is
        kind, named, words = type(error).__name__, isinstance(error, UlnaError), str(error)
    else:
        kind, named, words = "", False, "it was read"
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return {
        "error": kind,
        "named": named,
        "words": words[:2000],
        "length": len(words),
        "seconds": time.process_time() - begin,
        "MB": peak,
    }


def in_a_copy(read: Callable[[Path], object], path: Path) -> dict[str, object]:
    """The outcome in a copy of this process, which has so many seconds of the processor."""
    import resource

    source, sink = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS + 1, SECONDS + 1))
            os.write(sink, json.dumps(outcome(read, path)).encode())
        finally:
            os._exit(0)
    os.close(sink)
    with os.fdopen(source, "rb") as pipe:
        said = pipe.read()
    status = os.waitpid(child, 0)[1]
    return (
        json.loads(said)
        if said
        else {"error": f"ended with status {status}", "named": False, "words": "", "length": 0, "seconds": SECONDS}
    )


def main(folder: Path) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    known = readers()
    print(
        json.dumps({"address space": int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()}), flush=True
    )
    for k, (name, content) in enumerate(FILES.items()):
        path = folder / str(k) / name.split()[0]
        path.parent.mkdir()
        path.write_bytes(content())
        size = path.stat().st_size
        read = known.get(path.name) or known[path.suffix]
        print(json.dumps({"file": name, "bytes": size, **in_a_copy(read, path)}), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
