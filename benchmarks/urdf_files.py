"""Reads every URDF below a folder, and compares with Pinocchio: the share read, the poses, the refused files.

python benchmarks/urdf_files.py FOLDER [FOLDER ...]

Pinocchio parses with urdfdom, the parser of ROS. Without it the share refers to all files. It ignores Drake's ``<frame>``, which
is a link here: these links are not compared.
"""

import sys
import warnings
from collections import Counter
from contextlib import suppress
from pathlib import Path

from lxml import etree

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import ulna  # noqa: E402

try:
    import pinocchio as pin

    from pinocchio_peer import Peer, farthest_link
except ImportError:
    pin = None

_EQUAL = 1e-9  # m or 1; larger differences are listed


def peer_model(file: Path):
    """Pinocchio's model of a file, with its mimic option if available; None if it refuses the file."""
    if pin is None:
        return None
    for mimic in (True, False):
        with suppress(Exception):
            return pin.buildModelFromUrdf(str(file), mimic=mimic)
    return None


def difference(file: Path, robot: ulna.Robot, model) -> float | None:
    """The largest difference in any entry of any link's pose at 20 configurations; None if not comparable."""
    root = etree.parse(file, etree.XMLParser(recover=True, resolve_entities=False)).getroot()
    frames = {element.get("name") for element in root.iterfind("frame")}
    with suppress(Exception):
        return farthest_link(Peer(robot, model, without=frames), 20)
    return None


def main(folders: list[str]) -> None:
    """Print the counts, then files that only Pinocchio reads, differences, and files that neither reads."""
    files = sorted(file for folder in folders for file in Path(folder).rglob("*.urdf") if file.is_file())
    counts: Counter[str] = Counter()
    only_peer, neither, apart, farthest = [], [], [], 0.0
    for file in files:
        model, robot, reason = peer_model(file), None, ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                robot = ulna.load(file, srdf=False)
        except ulna.UlnaError as error:
            reason = str(error)
        counts[f"read by {'Ulna' if robot else ''}{' and ' if robot and model else ''}{'Pinocchio' if model else ''}"] += 1
        if robot is None:
            (neither if model is None else only_peer).append(f"{file}: {reason}")
        elif model is not None:
            off = difference(file, robot, model)
            if off is None or off > _EQUAL:
                apart.append(f"{file}: {'not compared' if off is None else off}")
            else:
                farthest = max(farthest, off)
    both, alone = counts["read by Ulna and Pinocchio"], counts["read by Pinocchio"]
    print(f"{len(files)} files, {counts['read by Ulna']} read by Ulna alone, {both} by both, {alone} by Pinocchio alone")
    if both + alone:
        share = both / (both + alone)
        print(f"of what Pinocchio reads Ulna reads {share:.2%}; poses differ by {farthest:.1e} at most")
    for title, lines in (("read by Pinocchio alone", only_peer), ("poses differ", apart), ("read by neither", neither)):
        print(f"\n{title}: {len(lines)}", *lines, sep="\n  ")


if __name__ == "__main__":
    main(sys.argv[1:])
