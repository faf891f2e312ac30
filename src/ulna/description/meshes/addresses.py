"""Rewrites mesh paths in URDF text as absolute ``file://`` addresses.

For programs that cannot resolve ``package://``, such as RViz.
"""

from collections.abc import Iterable
from pathlib import Path

from lxml import etree

from ulna.description.packages import resolve_uri
from ulna.errors import FileError, InputError, did_you_mean

_KINDS = ("given", "file")
_NAMING_FILES = ("mesh", "texture")


def with_mesh_paths(kind: str, text: str, folder: Path | None, package_dirs: Iterable[str | Path]) -> str:
    """The text with mesh and texture paths as they are (``"given"``), or as absolute ``file://`` addresses (``"file"``).

    Raises:
        FileError: One is not there; the message lists every path tried.
    """
    if kind not in _KINDS:
        raise InputError("mesh_paths", f"{kind!r} is not known{did_you_mean(str(kind), _KINDS)}")
    if kind == "given":
        return text
    root = etree.fromstring(text.encode(), etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False))
    named = [element for element in root.iter(*_NAMING_FILES) if element.get("filename")]
    places = _found_files((element.get("filename", "") for element in named), folder, package_dirs)
    for element in named:
        element.set("filename", places[element.get("filename", "")].resolve().as_uri())
    return etree.tostring(root.getroottree(), encoding="unicode")


def _found_files(uris: Iterable[str], folder: Path | None, package_dirs: Iterable[str | Path]) -> dict[str, Path]:
    """The file of each address; each is searched for once.

    Raises:
        FileError: One is not there; the message lists every path tried.
    """
    package_dirs = list(package_dirs)
    places = {uri: resolve_uri(uri, folder, package_dirs) for uri in dict.fromkeys(uris)}
    missing = [uri for uri, (path, _) in places.items() if path is None]
    for uri in missing[:1]:
        tried = "; ".join(map(str, places[uri][1])) or "nothing, for it leads out of its package"
        others = f" ({len(missing) - 1} more of this robot are missing)" if len(missing) > 1 else ""
        raise FileError(uri, f"no such file{others}; tried {tried}")
    return {uri: path for uri, (path, _) in places.items() if path is not None}
