"""Finds robots by name: bundled, of ``example-robot-data``, of ``robot_descriptions``. Downloads nothing."""

import re
from dataclasses import dataclass
from pathlib import Path

from ulna.description.names import cached_descriptions, panda
from ulna.description.names.arm_tables import ArmTable, arm_tables
from ulna.description.names.cached_descriptions import Named
from ulna.description.packages import package_folders
from ulna.errors import FileError, near_names, twin_in_words


@dataclass(frozen=True)
class Bundled:
    """A bundled description: its files in this folder, and its home configuration [rad or m]."""

    file: str
    home: tuple[float, ...]
    semantic_file: str | None = None

    def text(self) -> bytes:
        """The URDF document."""
        return Path(__file__).with_name(self.file).read_bytes()

    def semantics(self) -> Path | None:
        """The SRDF document's path, if there is one."""
        return None if self.semantic_file is None else Path(__file__).with_name(self.semantic_file)


_FILES = {"panda": Bundled("panda.urdf", panda.HOME), "fr3": Bundled("fr3.urdf", panda.HOME, "fr3.srdf")}
BUNDLED: dict[str, Bundled | ArmTable] = {
    **_FILES,
    **{name: arm for arm in arm_tables().values() for name in (arm.name, *arm.also)},
}
_FRANKA = {"panda": ("Panda", 3.0, 0.855), "fr3": ("Franka Research 3", 3.0, 0.855)}  # model, payload [kg], reach [m]
_MAX_NEAR = 4


def find_by_name(name: str) -> Named:
    """The file of a robot that is not bundled."""
    examples, cached = _files_by_package().values()
    if name in examples:
        return Named(examples[name])
    if name in cached:
        return cached_descriptions.find(name, cached[name])
    known = {
        **dict.fromkeys(cached, "robot_descriptions"),
        **dict.fromkeys(examples, "example-robot-data"),
        **dict.fromkeys(BUNDLED, "bundled"),
    }
    raise FileError(
        name, f"no such file{twin_in_words(name)}; and not a robot's name{_suggestion(name, known)}{_install_advice()}"
    )


@dataclass(frozen=True)
class KnownRobot:
    """A robot that ``ulna.load`` accepts by name.

    Attributes:
        name: Its name.
        also: Its other names.
        package: Its source: ``"bundled"``, ``"example-robot-data"`` or ``"robot_descriptions"``.
        path: Its file; None if it is bundled, or not downloaded by robot_descriptions yet.
        installed: Whether it can be loaded now.
        maker: Its manufacturer; None if unknown.
        model: Its maker's name for it.
        payload: The maker's rated payload [kg].
        reach: The maker's stated reach [m].
    """

    name: str
    also: tuple[str, ...]
    package: str
    path: str | None
    installed: bool
    maker: str | None = None
    model: str | None = None
    payload: float | None = None
    reach: float | None = None


def known_robots() -> list[KnownRobot]:
    """Every robot that can be loaded by name: bundled ones by maker, then by package and name.

    If several packages share a name, the first one counts.
    """
    found = [_bundled(name, [], "Franka Robotics", *_FRANKA[name]) for name in _FILES]
    found += [_bundled(arm.name, arm.also, arm.maker, arm.model, arm.payload, arm.reach) for arm in arm_tables().values()]
    taken = set(BUNDLED)
    for package, files in _files_by_package().items():
        by_file: dict[Path, list[str]] = {}
        for name in sorted(files.keys() - taken, key=lambda name: (len(name), name)):
            by_file.setdefault(files[name], []).append(name)
        taken |= files.keys()
        for file, (name, *also) in sorted(by_file.items(), key=lambda item: item[1]):
            path = file if package == "example-robot-data" else _cached(name, file)
            found.append(KnownRobot(name, tuple(also), package, None if path is None else str(path), path is not None))
    return found


def _bundled(name: str, also: list[str], maker: str, model: str, payload: float, reach: float) -> KnownRobot:
    return KnownRobot(name, tuple(also), "bundled", None, installed=True, maker=maker, model=model, payload=payload, reach=reach)


def rated_payload(name: str) -> float | None:
    """The maker's rated payload of a bundled arm [kg]; None for another robot."""
    known = {arm.name: arm.payload for arm in arm_tables().values()} | {name: of[1] for name, of in _FRANKA.items()}
    return known.get(name)


def packages_to_install() -> list[str]:
    """The packages, by their names for pip, that would add more robots."""
    return [package for package, files in _files_by_package().items() if not files]


def _files_by_package() -> dict[str, dict[str, Path]]:
    """The files by name of each package, by its pip name; the first package takes precedence."""
    return {"example-robot-data": example_robots(), "robot_descriptions": cached_descriptions.names()}


def _cached(name: str, module: Path) -> Path | None:
    try:
        return cached_descriptions.find(name, module).path
    except FileError:
        return None


def example_robots() -> dict[str, Path]:
    """The URDF files of example-robot-data by name: ``ur5_robot`` or in short ``ur5``, ``talos`` (reduced), ``hyq``."""
    folder = next((f / "robots" for f in package_folders("example-robot-data", None) if (f / "robots").is_dir()), None)
    files = {} if folder is None else {file: file.relative_to(folder).parts[0] for file in sorted(folder.rglob("*.urdf"))[::-1]}
    packages = list(files.values())
    alone = {(package.rpartition("_")[0] or package): file for file, package in files.items() if packages.count(package) == 1}
    whole = {file.stem: file for file in files}
    return {**_without("_reduced", whole), **alone, **whole, **_without("_robot", whole)}


def _without(end: str, files: dict[str, Path]) -> dict[str, Path]:
    return {name.removesuffix(end): file for name, file in files.items() if name.endswith(end)}


def _suggestion(name: str, known: dict[str, str]) -> str:
    variants = sorted(one for one in known if _normalized(name) and _normalized(one).startswith(_normalized(name)))
    near = list(dict.fromkeys([*variants, *near_names(name, known, _MAX_NEAR)]))[:_MAX_NEAR]
    if not near:
        return f"; {len(known)} names are known, none of them similar; `ulna list` prints them"
    return "; did you mean " + " or ".join(f"{one!r} ({known[one]})" for one in near) + "?"


def _normalized(name: str) -> str:
    """A name without case, dashes and spaces: ``UR10-e`` becomes ``ur10e``."""
    return re.sub(r"[\W_]", "", name.casefold())


def _install_advice() -> str:
    missing = packages_to_install()
    return f"; for more robots: pip install {' '.join(missing)}" if missing else ""
