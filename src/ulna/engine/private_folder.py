"""Opens folders of files to which only their user can write.

Machine code in them is executed without another check. So a folder is opened once, checked while it is open, and its files are
opened in it by the same descriptor. Someone who may rename a parent folder can redirect the path, but not the open folder.
"""

import contextlib
import os
import stat
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

_WAIT_S = 0.05  # between two looks at a lock
_HAS_MODES = hasattr(os, "geteuid")  # Windows: folders have access lists, which the user's own profile restricts to the user


class SharedFolderError(OSError):
    """Another user can write to a folder, or may have written to it."""


def cache_base() -> Path:
    """The folder of this user's caches: in ``NUMBA_CACHE_DIR``, or else in the user's own cache folder.

    A relative path in a variable is ignored, as the XDG base directory specification demands. It would depend on the process's
    current folder, whose creator could have put code there.

    Warns:
        RuntimeWarning: A variable has a relative path.

    Raises:
        RuntimeError: The user has no home folder.
    """
    if (given := absolute_path_of("NUMBA_CACHE_DIR")) is not None:
        return given / "ulna"
    if sys.platform == "win32":
        return (absolute_path_of("LOCALAPPDATA") or _home() / "AppData" / "Local") / "ulna" / "cache"
    if sys.platform == "darwin":
        return _home() / "Library" / "Caches" / "ulna"
    return (absolute_path_of("XDG_CACHE_HOME") or _home() / ".cache") / "ulna"


def absolute_path_of(variable: str) -> Path | None:
    """The path in an environment variable; None if it is not set, or relative."""
    text = os.environ.get(variable, "")
    if text and not Path(text).is_absolute():
        words = f"{variable} is {text[:200]!r}, a relative path, which is ignored; an absolute path is needed"
        warnings.warn(words, RuntimeWarning, stacklevel=2)
        return None
    return Path(text) if text else None


def _home() -> Path:
    home = Path.home()
    if not home.is_absolute():
        raise RuntimeError("the home folder is a relative path")
    return home


class PrivateFolder(contextlib.AbstractContextManager):
    """An open folder; a ``with`` block closes it.

    Attributes:
        path: Its path when it was opened.
    """

    def __init__(self, path: Path, descriptor: int | None) -> None:
        self.path, self._descriptor = path, descriptor

    def __exit__(self, *_: object) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)

    def folder(self, name: str) -> "PrivateFolder":
        """The folder ``name`` in this one, created if necessary.

        Raises:
            SharedFolderError: It belongs to another user, is open to others, or is a link.
            OSError: It cannot be created or opened.
        """
        with contextlib.suppress(FileExistsError):
            os.mkdir(self._name_in(name), 0o700, dir_fd=self._descriptor)
        path = self.path / name
        return PrivateFolder(path, _open_folder(path, self._name_in(name), self._descriptor, mend=False) if _HAS_MODES else None)

    def read(self, name: str) -> bytes:
        """The content of a file, which is marked as used now.

        Raises:
            OSError: It does not exist, or cannot be read.
        """
        os.utime(self._name_in(name), dir_fd=self._descriptor)
        with open(self._name_in(name), "rb", opener=self._open) as file:
            return file.read()

    def has(self, name: str) -> bool:
        """Whether a file exists; marks it as used now."""
        with contextlib.suppress(FileNotFoundError):
            os.utime(self._name_in(name), dir_fd=self._descriptor)
            return True
        return False

    def note(self, name: str, days: float = 400) -> bool:
        """Write an empty file, and remove files that were not used for ``days``; returns True.

        Raises:
            OSError: It cannot be written.
        """
        self.remove_unused(days)
        self.write(name, b"")
        return True

    def write(self, name: str, content: bytes) -> None:
        """Write a file completely or not at all; a killed process leaves a file that ends in ``.part``.

        Raises:
            OSError: It cannot be written.
        """
        part, here = self._name_in(f"{name}.{os.urandom(8).hex()}.part"), self._descriptor
        try:
            with open(part, "xb", opener=self._open) as file:
                file.write(content)
            os.replace(part, self._name_in(name), src_dir_fd=here, dst_dir_fd=here)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(part, dir_fd=here)
            raise

    def lock(self, name: str) -> int | None:
        """Lock a file, created if necessary, until the returned descriptor is closed; None if another process has locked it.

        Raises:
            OSError: The file cannot be opened.
        """
        descriptor = self._open(self._name_in(name), os.O_RDWR | os.O_CREAT)
        try:
            lock_file(descriptor)
        except OSError:
            os.close(descriptor)
            return None
        return descriptor

    def is_locked(self, name: str) -> bool:
        """Whether another process has locked a file. A file that does not exist is not locked."""
        if not self.has(name):
            return False
        descriptor = self.lock(name)
        if descriptor is not None:
            os.close(descriptor)
        return descriptor is None

    def wait_for(self, name: str, seconds: float) -> bool:
        """Wait while another process has locked a file, at most some seconds; returns whether it was locked."""
        end, was_locked = time.monotonic() + seconds, False
        while self.is_locked(name) and time.monotonic() < end:
            was_locked = True
            time.sleep(_WAIT_S)
        return was_locked

    def remove_unused(self, days: float) -> None:
        """Remove the files that were not used for ``days``."""
        for entry in self._entries():
            with contextlib.suppress(OSError):  # another process removes it too
                if _is_unused(entry, days):
                    os.unlink(self._name_in(entry.name), dir_fd=self._descriptor)

    def remove_unused_folders(self, begin: str, days: float) -> None:
        """Remove the folders with a prefix that were not used for ``days``, with their files."""
        for entry in self._entries():
            with contextlib.suppress(OSError):  # another user's, or it contains folders
                if entry.name.startswith(begin) and _is_unused(entry, days):
                    with self.folder(entry.name) as unused:
                        unused.remove_unused(-1)
                    os.rmdir(self._name_in(entry.name), dir_fd=self._descriptor)

    def touch(self) -> None:
        """Mark the folder itself as used now."""
        os.utime(self.path if self._descriptor is None else self._descriptor)

    def _entries(self) -> Iterator[os.DirEntry]:
        with os.scandir(self.path if self._descriptor is None else self._descriptor) as entries:
            yield from entries

    def _open(self, path: str, flags: int) -> int:
        return os.open(path, flags, 0o600, dir_fd=self._descriptor)

    def _name_in(self, name: str) -> str:
        """The name to use with the descriptor; the path without one."""
        return str(self.path / name) if self._descriptor is None else name


def lock_file(descriptor: int) -> None:
    """Lock an open file until it is closed.

    Raises:
        OSError: Another process holds the lock.
    """
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    import msvcrt  # noqa: PLC0415 -- of Windows alone

    msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]


def private_folder(base: Path) -> PrivateFolder:
    """The folder ``base``, created if necessary, accessible to this user only (mode 0700); it may be this user's link.

    Raises:
        SharedFolderError: It belongs to another user, or any user can replace it.
        OSError: It cannot be created or opened.
    """
    base.parent.mkdir(parents=True, exist_ok=True)
    path = Path(os.path.realpath(base))
    if not _HAS_MODES:
        path.mkdir(exist_ok=True)
        return PrivateFolder(path, None)
    for above in {*base.absolute().parents, *path.parents}:
        _check_above(above)
    path.mkdir(mode=0o700, exist_ok=True)
    return PrivateFolder(path, _open_folder(path, str(path), None, mend=True))


def _open_folder(path: Path, name: str, inside: int | None, *, mend: bool) -> int:
    """The descriptor of this user's folder, whose mode is set to 0700 if ``mend`` (earlier versions used another)."""
    try:
        descriptor = os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=inside)
    except OSError:
        _check(path, os.stat(name, dir_fd=inside, follow_symlinks=False))
        raise
    try:
        if mend and os.fstat(descriptor).st_uid == os.geteuid():
            os.fchmod(descriptor, 0o700)
        _check(path, os.fstat(descriptor))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _check(path: Path, status: os.stat_result) -> None:
    if not stat.S_ISDIR(status.st_mode):
        raise SharedFolderError(f"{path} is not a folder")
    if status.st_uid != os.geteuid():
        raise SharedFolderError(f"{path} belongs to another user (number {status.st_uid})")
    if stat.S_IMODE(status.st_mode) != 0o700:
        raise SharedFolderError(f"{path} is open to other users (mode {stat.S_IMODE(status.st_mode):04o}; 0700 is needed)")


def _check_above(folder: Path) -> None:
    """Refuse a parent folder in which others can replace ours: writable by others, unless sticky and trusted.

    The sticky bit prevents other users from renaming folders, but not the owner, who must be root or this user.
    """
    status = folder.stat()
    if status.st_mode & stat.S_IWOTH and not (status.st_mode & stat.S_ISVTX and status.st_uid in (0, os.geteuid())):
        raise SharedFolderError(f"{folder} lets other users replace its files (mode {stat.S_IMODE(status.st_mode):04o})")


def _is_unused(entry: os.DirEntry, days: float) -> bool:
    return entry.stat(follow_symlinks=False).st_mtime < time.time() - days * 86400
