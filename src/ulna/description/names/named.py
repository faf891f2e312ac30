"""Holds what a robot's name refers to: a file, and what it needs to be read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Named:
    """The file of a robot that goes by a name, with the arguments and the folders of packages that its package gives it."""

    path: Path
    xacro_args: Mapping[str, object] = field(default_factory=dict)
    package_dirs: tuple[Path, ...] = ()
