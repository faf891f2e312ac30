"""The robots that come with the packages example-robot-data and rtb-data, and what is known of them."""

import importlib.util
import sys
import warnings
from pathlib import Path

import ulna

SHARE = Path("cmeel.prefix") / "share" / "example-robot-data" / "robots"
EXAMPLES = next(Path(entry) / SHARE for entry in sys.path if (Path(entry) / SHARE).is_dir())
# For these Pinocchio's mimic option fails: a mimic stands before its leader.
DEFEAT_THE_MIMIC_OPTION = {"romeo", "talos_full_v2", "talos_full_v2_box"}

_FOUND = importlib.util.find_spec("rtbdata")
RTB = None if _FOUND is None else Path(next(iter(_FOUND.submodule_search_locations or ())))
_PARTS = ("_macro.xacro", "common_colours.xacro", "common_constants.xacro", "common_materials.xacro")


def example_urdfs() -> list[Path]:
    return sorted(EXAMPLES.rglob("*.urdf"))


def example_srdfs() -> list[Path]:
    return sorted(EXAMPLES.rglob("*.srdf"))


def load_baxter() -> ulna.Robot:
    """Baxter with the convex hulls of its meshes and the pairs of its SRDF, which names links that it has not."""
    (srdf,) = (file for file in example_srdfs() if file.stem == "baxter_manipulation")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ulna.DescriptionWarning)
        return ulna.load("baxter", srdf=srdf).with_convex_hulls()


def rtb_xacros() -> list[Path]:
    """The xacro files of rtb-data that are whole robots."""
    files = [] if RTB is None else sorted(RTB.rglob("*.xacro"))
    return [file for file in files if not file.name.endswith(_PARTS) and "accessories" not in file.parts]


def rtb_package_dirs(links: Path) -> list[Path]:
    """Where the packages of these lie. Some are in folders of other names: for those a folder of links is filled."""
    assert RTB is not None
    for folder in (RTB / "xacro" / "kuka_description").glob("kuka_*"):
        (links / f"{folder.name}_support").symlink_to(folder)
    (links / "abb_irb140").symlink_to(RTB / "xacro" / "abb_irb140_description")
    return [links, RTB / "xacro", RTB / "xacro" / "kuka_description"]
