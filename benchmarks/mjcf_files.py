"""Reads every MJCF model below a folder, and compares it with MuJoCo's own compiled model: poses, limits and shapes.

python benchmarks/mjcf_files.py FOLDER [FOLDER ...]

If the file of a mesh, a texture or a skin is absent, such assets and their uses are removed, for both sides.
"""

import shutil
import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path

import mujoco
from lxml import etree

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import ulna
from mujoco_peer import Peer, farthest

_N = 20  # configurations
_EQUAL = 1e-12  # m or 1
_ASSETS = ("mesh", "hfield", "skin", "texture", "model")
_USERS = {"mesh", "hfield", "material", "texture", "skin"}  # attributes of geoms, sites and materials


def compiled(file: Path):
    """MuJoCo's model of a file, or the reason why there is none."""
    try:
        return mujoco.MjModel.from_xml_path(str(file)), ""
    except ValueError as error:
        return None, " ".join(str(error).split())


def strip(file: Path) -> None:
    """Remove assets that are files, and their uses, from a document."""
    try:
        document = etree.parse(file)
    except etree.XMLSyntaxError:
        return
    root = document.getroot()
    in_defaults = [element for element in root.iter("geom") if element.getparent().tag == "default"]
    meshes = {element.getparent().get("class") for element in in_defaults if element.get("mesh")}
    for element in list(root.iter("*")):
        parent = element.getparent()
        if parent is None:
            continue
        is_asset = parent.tag == "asset" and element.tag in _ASSETS
        is_made_of_one = parent.tag != "default" and (element.get("mesh") or element.get("type") in {"mesh", "hfield", "sdf"})
        by_class = element.tag == "geom" and element.get("class") in meshes - {None}
        if is_asset or is_made_of_one or by_class or element.tag in {"flexcomp", "pair", "keyframe"}:
            parent.remove(element)
            continue
        for name in _USERS & set(element.attrib):
            if not (element.tag == "material" and name == "material"):
                del element.attrib[name]
        if parent.tag == "default" and element.get("type") in {"mesh", "hfield", "sdf"}:
            del element.attrib["type"]
    if root.tag == "mujoco":
        compiler = root.find("compiler")
        compiler = etree.SubElement(root, "compiler") if compiler is None else compiler
        compiler.set("boundmass", "0.001")
        compiler.set("boundinertia", "1e-6")
    document.write(file)


def stripped(folder: Path, to: Path) -> None:
    """Copy the documents below a folder, stripped."""
    for file in folder.rglob("*.xml"):
        copy = to / file.relative_to(folder)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, copy)
        strip(copy)


def judged(file: Path, model) -> tuple[str, str, float]:
    """The outcome for a file, the reason, and the largest difference of its poses."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            robot = ulna.load(file)
    except ulna.UlnaError as error:
        return "refused", str(error), 0.0
    wrong, apart = Peer(robot, model).others(), farthest(robot, model, _N)
    if wrong or not apart <= _EQUAL:
        return "differs", f"poses {apart:.1e}; {', '.join(wrong)}", apart
    return "equal", "", apart


def read(folder: Path) -> None:
    """Read the files of one folder, and print the counts, then the differences."""
    counts: Counter[str] = Counter()
    lines: dict[str, list[str]] = {"refused": [], "differs": [], "not compiled by MuJoCo": []}
    largest, without = 0.0, 0
    with tempfile.TemporaryDirectory() as temporary:
        copies = Path(temporary)
        stripped(folder, copies)
        for file in sorted(folder.rglob("*.xml")):
            if b"<mujoco" not in file.read_bytes() or b"<mujocoinclude" in file.read_bytes():
                continue
            used, (model, why) = file, compiled(file)
            if model is None:
                used = copies / file.relative_to(folder)
                model, second = compiled(used)
                without += model is not None
                why = f"{why} / {second}"
            what, reason, apart = ("not compiled by MuJoCo", why, 0.0) if model is None else judged(used, model)
            counts[what] += 1
            largest = max(largest, apart)
            if what in lines:
                lines[what].append(f"{file.relative_to(folder)}: {reason}")
    print(f"{folder}: {sum(counts.values())} models, {dict(counts)}; {without} without meshes; poses differ by {largest:.1e}")
    for title, some in lines.items():
        print(f"\n{title}: {len(some)}", *some, sep="\n  ")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        read(Path(name))
