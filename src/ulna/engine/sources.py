"""Hashes the sources of an entry: its own file and every file that it takes names from.

The imports are found in the text, so nothing is imported. A file counts as it was when its functions were marked for the
compiler, at load time: editing a file while a program runs does not change what the program compiles.
"""

import hashlib
import re
from collections.abc import Iterator
from functools import cache
from os import sep
from os.path import basename, dirname, isdir, isfile, join  # strings: paths take three times as long, in every process
from pathlib import Path

_PACKAGES = dirname(dirname(dirname(__file__)))  # the folder that contains Ulna's package
_IMPORT = re.compile(r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import\b([ \t]*\([^)]*\)|[^\n]*)|import[ \t]+([^\n]*))", re.MULTILINE)
# Raised errors change no machine code, nor does code compiled elsewhere, nor the process that compiles.
_WITHOUT_CODE = {"ulna.errors", "ulna.engine.ahead", "ulna.engine.second_process"}
_COMMENT, _CONTINUED = re.compile(r"#[^\n]*"), re.compile(r"\\\n")


@cache
def text_of(file: str) -> bytes:
    """The content of a file at the first request."""
    return Path(file).read_bytes()


@cache
def sources_hash(file: str) -> str:
    """Hash of a file and of all files that it uses, directly or through others, in hexadecimal."""
    digest = hashlib.sha256()
    for name, used in sorted((_name(used), used) for used in files_used(file)):
        digest.update(name.encode() + b"\0" + text_of(used) + b"\0")
    return digest.hexdigest()[:16]


def files_used(file: str) -> set[str]:
    """A file and all files of its own package and of Ulna that it uses, directly or through others.

    The file of a package (``__init__.py``) counts if names are taken from it, not if it is only on the path to a module: Ulna's
    own imports everything.
    """
    found, waiting = {file}, [file]
    while waiting:
        new = _used_by(waiting.pop()) - found
        found |= new
        waiting += new
    return found


def imports_of(text: str) -> Iterator[tuple[str, list[str]]]:
    """The modules that a text imports anywhere, each with the names taken from it."""
    for module, taken, imported in _IMPORT.findall(_CONTINUED.sub(" ", _COMMENT.sub("", text))):
        if module:
            yield module, re.findall(r"\w+", taken)
        for name in re.findall(r"[\w.]+", imported):
            yield name, []


@cache
def _used_by(file: str) -> set[str]:
    """The files of the modules that a file imports, as far as they are found near it or in Ulna."""
    found, folder = set(), dirname(file)
    for module, names in imports_of(text_of(file).decode()):
        place = None if module in _WITHOUT_CODE else _place(module, folder)
        found |= set() if place is None else _files_of(place, names)
    return found


def _files_of(place: str, names: list[str]) -> set[str]:
    """The file of a module; for a package its own file, and those of its modules among ``names``."""
    if isfile(f"{place}.py"):
        return {f"{place}.py"}
    if not isdir(place):
        return set()
    inside = (join(place, f"{name}.py") for name in names)
    packages = (join(place, name, "__init__.py") for name in names)
    return {part for part in (join(place, "__init__.py"), *inside, *packages) if isfile(part)}


@cache
def _place(module: str, folder: str) -> str | None:
    """The path of an imported module without ``.py``, or of the package's folder; None if it is not found.

    The search covers the parents of ``folder`` with the package's name, then ``folder``, then Ulna's folder.
    """
    name = module.lstrip(".")
    parts = name.split(".") if name else []
    if name != module:  # relative: one dot is the folder itself
        for _ in range(len(module) - len(name) - 1):
            folder = dirname(folder)
        return join(folder, *parts)
    homes, above = [], folder
    for _ in range(folder.count(sep)):
        if basename(above) == parts[0]:
            homes.append(dirname(above))
        above = dirname(above)
    homes += [folder, *([_PACKAGES] if parts[0] == "ulna" else [])]
    return next((place for place in (join(home, *parts) for home in homes) if isfile(f"{place}.py") or isdir(place)), None)


@cache
def _name(file: str) -> str:
    """The file's place among its packages, which is the same in every clone."""
    folder, parts = dirname(file), [basename(file)]
    while isfile(join(folder, "__init__.py")):
        parts.append(basename(folder))
        folder = dirname(folder)
    return "/".join(reversed(parts))
