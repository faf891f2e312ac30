"""Decides which files a description may read.

They are the files in its folder, in its package, in ``package_dirs``, and in the packages that it finds.
"""

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fnmatch import fnmatch
from pathlib import Path

from ulna.description.file_bytes import regular_file_bytes
from ulna.description.packages import folders_above, installed_folders, package_folders

_WILDCARD = re.compile(r"[*?[]")
_MAX_NAMES = 100_000  # files and folders compared with one pattern; links to "." can produce endless names


class OutsideError(Exception):
    """A description refers to a file that it may not read, or to a package that does not exist."""


class Readable:
    """The folders that a description may read.

    A symbolic link counts as its target. The links of an installed package are the exception: ``colcon build --symlink-install``
    and some installers of Python packages make every file a link.
    """

    def __init__(self, folder: Path | None, package_dirs: Iterable[str]) -> None:
        self.folder, self.package_dirs = folder, list(package_dirs)
        self._roots: set[str] = set()
        self._linked_roots: set[str] = set()
        for path in self.package_dirs:
            self.admit(Path(path))
        if folder is not None:
            self.admit(folder)
            for package in [path for path in folders_above(folder) if (path / "package.xml").is_file()][:1]:
                self.admit(package)

    def admit(self, folder: Path) -> None:
        """Allow reading a folder."""
        self._roots.add(os.path.realpath(folder))
        given = os.path.abspath(folder)  # noqa: PTH100 - links stay
        if any(_within(given, os.path.abspath(installed)) for installed in installed_folders()):  # noqa: PTH100
            self._linked_roots.add(given)

    def admits(self, path: str | Path) -> bool:
        """Whether a path leads into one of the folders."""
        real, given = os.path.realpath(path), os.path.abspath(path)  # noqa: PTH100 - links stay
        if any(_within(real, root) for root in self._roots):
            return True
        return ".." not in Path(path).parts and any(_within(given, root) for root in self._linked_roots)

    def find(self, name: str) -> str:
        """The folder of a package; outside ``package_dirs`` and ROS's paths it must have a ``package.xml``."""
        if not name or name.startswith(".") or "/" in name or "\\" in name:
            raise OutsideError(f"$(find {name}): {name!r} is not the name of a package")
        folders = [path for path in package_folders(name, self.folder, self.package_dirs) if path.is_dir()]
        given = set(package_folders(name, None, self.package_dirs))
        if not folders:
            raise OutsideError(f"$(find {name}): no such package in package_dirs, ROS_PACKAGE_PATH or the folders above the file")
        reasons = []
        for folder in folders:
            reason = self.admit_package(folder, given=folder in given)
            if not reason:
                return str(folder)
            reasons.append(f"{folder} {reason}; if it is the right package: package_dirs=[{str(folder)!r}]")
        raise OutsideError(f"$(find {name}): {reasons[0]}")

    def admit_package(self, folder: Path, *, given: bool) -> str:
        """Allow reading a package; returns the reason for a refusal, if any.

        A package that was not ``given`` may be any folder of that name.
        """
        if self.admits(folder):
            return ""
        if not given and os.path.realpath(folder) != str(Path(os.path.realpath(folder.parent)) / folder.name):
            return "is a link"
        if not given and not any((folder / name).is_file() for name in ("package.xml", "model.config")):
            return "has no package.xml"
        self.admit(folder)
        return ""

    def read(self, path: str, most: int) -> bytes:
        """The bytes of a regular file, up to one more than ``most``."""
        self._check(path)
        return regular_file_bytes(path, most)

    def matching(self, pattern: str) -> list[str]:
        """The readable files that match a pattern such as ``parts/*.xacro``."""
        parts = Path(pattern).parts
        first = next((k for k, part in enumerate(parts) if _WILDCARD.search(part)), len(parts))
        if ".." in parts[first:]:
            raise OutsideError(f"reads {pattern}, in which '..' comes after a wildcard")
        paths = [str(Path(*parts[:first]))]
        self._check(paths[0])
        n_names = 0
        for part in parts[first:]:
            found = []
            for path, name in _names_in(paths, part):
                n_names += 1
                if n_names > _MAX_NAMES:
                    raise OutsideError(f"reads {pattern}, for which more than {_MAX_NAMES} names would be compared")
                if fnmatch(name, part) and (part.startswith(".") or not name.startswith(".")):
                    found.append(os.path.join(path, name))  # noqa: PTH118 - text in, text out, as xacro does
            paths = found
        return [path for path in sorted(paths) if os.path.lexists(path) and self.admits(path)]

    def _check(self, path: str) -> None:
        if not self.admits(path):
            advice = f"to allow it: package_dirs=[{os.path.dirname(os.path.realpath(path))!r}]"  # noqa: PTH120 - text
            raise OutsideError(f"reads {path}, which lies outside the document's folder, its package and package_dirs; {advice}")


def _names_in(folders: Iterable[str], part: str) -> Iterator[tuple[str, str]]:
    """Each folder with each of its names that may match a part of a pattern."""
    for folder in folders:
        if not _WILDCARD.search(part):
            yield folder, part
            continue
        with suppress(OSError), os.scandir(folder) as entries:
            for entry in entries:
                yield folder, entry.name


def _within(path: str, root: str) -> bool:
    return path == root or path.startswith(root.rstrip(os.sep) + os.sep)
