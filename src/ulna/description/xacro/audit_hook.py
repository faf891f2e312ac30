"""What a xacro document may do while it is expanded: compute, and read files in the folders that it was given.

xacro evaluates Python, and the names that it hides can be reached by detours. So the expansion runs behind an audit hook
(PEP 578), which the interpreter asks before any file is opened, any module imported, any process started, and which cannot be
taken away again.
"""

import os
import sys
from collections.abc import Iterable
from pathlib import Path

from ulna.description.packages import package_folders

_LISTING = ("os.listdir", "os.scandir", "glob.glob", "glob.glob/2")  # for includes such as parts/*.xacro
_REFUSED = ("import", "os.", "subprocess.", "socket.", "shutil.", "ctypes.", "pty.", "tempfile.", "sys._", "sys.set", "gc.")
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_PACKAGE_LEVELS = 6  # above a document, in which its own package may begin


class FenceError(Exception):
    """A document reached for what it may not have."""


class Fence:
    """The folders that a document may read: its own, its package's, those of ``package_dirs``, and those of packages found."""

    def __init__(self, folder: Path | None, package_dirs: Iterable[str]) -> None:
        self.folder, self.package_dirs = folder, list(package_dirs)
        self.roots: set[str] = set()
        self.open_for_us = False
        for path in self.package_dirs:
            self.admit(Path(path))
        if folder is not None:
            self.admit(folder)
            above = [folder, *folder.parents][:_PACKAGE_LEVELS]
            for package in [path for path in above if (path / "package.xml").is_file()][:1]:
                self.admit(package)

    def admit(self, folder: Path) -> None:
        """Let a folder be read."""
        self.roots |= {os.path.abspath(folder), os.path.realpath(folder)}  # noqa: PTH100 - with links, and without

    def find(self, name: str) -> str:
        """The folder of a package. One that is not in ``package_dirs`` or ROS's paths, but above, must have a ``package.xml``."""
        if not name or name.startswith(".") or "/" in name or "\\" in name:
            raise LookupError(f"$(find {name}): {name!r} is no package's name")
        self.open_for_us = True  # each folder's package.xml is read
        try:
            folders = [path for path in package_folders(name, self.folder, self.package_dirs) if path.is_dir()]
            given = set(package_folders(name, None, self.package_dirs))
        finally:
            self.open_for_us = False
        if not folders:
            raise LookupError(f"$(find {name}): no such package in package_dirs, ROS_PACKAGE_PATH or the folders above the file")
        for folder in folders:
            if folder in given or (folder / "package.xml").is_file():
                self.admit(folder)
                return str(folder)
        raise LookupError(f"$(find {name}): {folders[0]} has no package.xml; if it is the one, name its folder in package_dirs")

    def admits(self, path: str) -> bool:
        """Whether a path lies in one of the folders. A link out of them was laid by their owner; one with ``..`` is followed."""
        whole = os.path.realpath(path) if ".." in Path(path).parts else os.path.abspath(path)  # noqa: PTH100 - links stay
        return any(whole == root or whole.startswith(root.rstrip(os.sep) + os.sep) for root in self.roots)

    def close(self) -> None:
        """From now on, refuse all but computing and reading in these folders."""
        sys.addaudithook(self._asked)

    def _asked(self, event: str, arguments: tuple) -> None:
        if self.open_for_us:
            return
        if event == "open":
            path, mode, flags = arguments
            self._only_read(os.fsdecode(path) if isinstance(path, (str, bytes)) else "", mode, flags)
        elif event in _LISTING:
            self._only_read(os.fsdecode(arguments[0] or "."), "r", 0)
        elif event.startswith(_REFUSED):
            raise FenceError(f"a description may not do this: {event} {_words(arguments)}".rstrip())

    def _only_read(self, path: str, mode: str | None, flags: int) -> None:
        if flags & _WRITING or not set(mode or "r") <= set("rbtU"):
            raise FenceError(f"a description may not write: {path}")
        if not self.admits(path):
            raise FenceError(f"reads {path}, which lies outside the document's folder, its package and package_dirs")


def _words(arguments: tuple) -> str:
    return " ".join(str(argument) for argument in arguments if isinstance(argument, str))[:80]
