"""Finds the robots of the package robot_descriptions that are in its cache.

The package is github.com/robot-descriptions/robot_descriptions.py. Its modules download when they are imported. So each is run
with a replacement for the one function that downloads. The replacement returns the folder in the cache, or raises an error that
says how to fill the cache.
"""

import builtins
import importlib.util
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ulna.engine.private_folder import absolute_path_of
from ulna.errors import FileError


@dataclass(frozen=True)
class Named:
    """The file of a named robot, with the arguments and package folders from its package."""

    path: Path
    xacro_args: Mapping[str, object] = field(default_factory=dict)
    package_dirs: tuple[Path, ...] = ()


_READS_URDF = re.compile(r"^(URDF_PATH|XACRO_PATH)\b", re.MULTILINE)


def names() -> dict[str, Path]:
    """The modules that describe a robot as URDF or xacro, by the robot's name, in short (``ur5e``) and in full."""
    spec = importlib.util.find_spec("robot_descriptions")
    folders = [] if spec is None else [Path(folder) for folder in spec.submodule_search_locations or ()]
    files = [file for folder in folders for file in sorted(folder.glob("*_description.py")) if not file.name.startswith("_")]
    files = [file for file in files if _READS_URDF.search(file.read_text(encoding="utf-8"))]
    return {file.stem: file for file in files} | {file.stem.removesuffix("_description"): file for file in files}


def find(name: str, module: Path) -> Named:
    """The URDF or xacro file that a module points to, with its arguments and its packages."""
    repositories = _run(module.with_name("_repositories.py"), None)["REPOSITORIES"]

    def clone_to_cache(description_name: str, commit: str | None = None) -> str:
        cache = absolute_path_of("ROBOT_DESCRIPTIONS_CACHE") or Path("~/.cache/robot_descriptions").expanduser()
        folder = repositories[description_name].cache_path
        folder = cache / (folder if commit is None else f"{folder}-{commit}/{folder}")
        if not folder.is_dir():
            message = f"robot_descriptions knows it, but {folder} is not there; python -m robot_descriptions pull {module.stem}"
            raise FileError(name, f"{message} downloads it")
        return str(folder)

    found = _run(module, clone_to_cache)
    path = Path(found["URDF_PATH"] if "URDF_PATH" in found else found["XACRO_PATH"])
    folders = [Path(found[key]) for key in ("PACKAGE_PATH", "REPOSITORY_PATH") if key in found]
    packages = [*found.get("XACRO_PACKAGE_PATHS", {}).values(), *folders, *(folder.parent for folder in folders)]
    return Named(path, {} if "URDF_PATH" in found else found.get("XACRO_ARGS", {}), tuple(map(Path, packages)))


def _run(module: Path, clone_to_cache: Any) -> dict[str, Any]:
    """The names that a module defines, executed instead of imported."""

    def imported(name: str, given=None, local=None, fromlist=(), level: int = 0):
        if (name, level) == ("_cache", 1):
            return SimpleNamespace(clone_to_cache=clone_to_cache)
        return __import__(name, given, local, fromlist, level)

    package = module.parent.name
    defined: dict[str, Any] = {
        "__name__": f"{package}.{module.stem}",
        "__package__": package,
        "__file__": str(module),
        "__builtins__": {**vars(builtins), "__import__": imported},
    }
    try:
        exec(compile(module.read_bytes(), str(module), "exec"), defined)  # noqa: S102 - as an import would
    except FileError:
        raise
    except Exception as error:
        raise FileError(str(module), f"cannot be read ({type(error).__name__}: {error})") from error
    return defined
