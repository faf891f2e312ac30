"""From whatever names a robot to its description: a bundled name, a path, or the text itself."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ulna.errors import FileError, InputError, did_you_mean
from ulna.io.urdf import read_urdf
from ulna.io.xacro import expand_xacro, is_xacro
from ulna.io.xml import parse
from ulna.model.description import Description
from ulna.robots.bundled import BUNDLED


def load_description(
    source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]
) -> tuple[Description, tuple[float, ...] | None]:
    """The description, and for a bundled robot its home configuration."""
    if not isinstance(source, (str, Path)):
        raise InputError("source", f"{type(source).__name__}; a name, a path or URDF text is expected")
    if isinstance(source, str) and not source.strip():
        raise InputError("source", "an empty string; a name, a path or URDF text is expected")
    if isinstance(package_dirs, (str, Path)) or not isinstance(package_dirs, Iterable):
        raise InputError("package_dirs", f"{package_dirs!r}; a list of folders is expected")
    if not isinstance(xacro_args, Mapping):
        raise InputError("xacro_args", f"{xacro_args!r}; a dict of names and values is expected")
    if isinstance(source, str) and source in BUNDLED:
        bundled = BUNDLED[source]
        _refuse_arguments(source, xacro_args)
        return read_urdf(bundled.text(), bundled.file), bundled.home
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return _read(_encoded(source), "URDF text", None, xacro_args, package_dirs), None
    path = Path(source)
    return _read(_bytes(path), path.name, path.parent, xacro_args, package_dirs), None


def _read(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]
) -> Description:
    if is_xacro(parse(text, source)):
        text = expand_xacro(text, source, folder, {k: str(v) for k, v in xacro_args.items()}, package_dirs)
        source = f"{source} (expanded)"
    else:
        _refuse_arguments(source, xacro_args)
    return read_urdf(text, source)


def _encoded(source: str) -> bytes:
    """URDF text as UTF-8, without an encoding that it may declare, and without what stands before an XML declaration."""
    text = source.lstrip("\ufeff")
    if text.lstrip().startswith("<?xml"):
        text = re.sub(r"""\s+encoding=(["'])[^"']*\1""", "", text.lstrip(), count=1)
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise InputError("source", f"text that is not Unicode ({error})") from None


def _refuse_arguments(source: str, xacro_args: Mapping[str, object]) -> None:
    if xacro_args:
        raise InputError("xacro_args", f"{source} is not a xacro file, so it takes no arguments")


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        hint = ""
        if path.parent == Path() and not path.suffix:
            hint = f"; nor is it a bundled robot{did_you_mean(str(path), BUNDLED)}"
        raise FileError(str(path), f"no such file{hint}") from None
    except (OSError, ValueError) as error:
        raise FileError(str(path), getattr(error, "strerror", None) or str(error)) from None
