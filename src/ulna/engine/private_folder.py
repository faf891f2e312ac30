"""Makes folders for machine code to which only their user can write. Used by ``cache`` and by hulls.

The code in them is executed without another check.
"""

import os
import stat
import sys
from pathlib import Path


class SharedFolderError(OSError):
    """Another user can write to a folder, or may have done so."""


def cache_base() -> Path:
    """The folder of this user's caches: in ``NUMBA_CACHE_DIR``, or else in the user's own cache folder."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"]) / "ulna"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ulna" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "ulna"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ulna"


def make_private(base: Path, name: str) -> Path:
    """The folder ``name`` in ``base``, created if necessary; both are accessible to this user only (mode 0700).

    Raises:
        SharedFolderError: One of them belongs to another user, or other users can write to it or replace it.
        OSError: One of them cannot be created.
    """
    base.parent.mkdir(parents=True, exist_ok=True)
    folder = base / name
    if not hasattr(os, "geteuid"):  # Windows: folders have access lists, which the user's own profile sets for the user alone
        folder.mkdir(parents=True, exist_ok=True)
        return folder
    for above in base.absolute().parents:
        _check_above(above)
    base.mkdir(mode=0o700, exist_ok=True)
    if _status(base).st_uid == os.geteuid():
        base.chmod(0o700)  # earlier versions used another mode; the folder in it is checked separately
    folder.mkdir(mode=0o700, exist_ok=True)
    for one in (base, folder):
        _check_own(one)
    return folder


def _status(folder: Path) -> os.stat_result:
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode):
        raise SharedFolderError(f"{folder} is no folder")
    return status


def _check_own(folder: Path) -> None:
    status = _status(folder)
    if status.st_uid != os.geteuid():
        raise SharedFolderError(f"{folder} belongs to another user (number {status.st_uid})")
    if stat.S_IMODE(status.st_mode) != 0o700:
        raise SharedFolderError(f"{folder} is open to other users (mode {stat.S_IMODE(status.st_mode):04o}; 0700 is needed)")


def _check_above(folder: Path) -> None:
    """Refuse a parent folder in which others can replace ours: one that they can write to, unless it is sticky and trusted.

    The sticky bit stops other users from renaming folders, but not the owner, who must be root or this user.
    """
    status = folder.stat()
    if status.st_mode & stat.S_IWOTH and not (status.st_mode & stat.S_ISVTX and status.st_uid in (0, os.geteuid())):
        raise SharedFolderError(f"{folder} lets other users exchange what lies in it (mode {stat.S_IMODE(status.st_mode):04o})")
