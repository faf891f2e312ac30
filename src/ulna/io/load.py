"""From whatever names a robot to its description: a bundled name, a path, or the text itself."""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from ulna.errors import DescriptionWarning, FileError, InputError, did_you_mean
from ulna.io.document import expanded, open_document, refuse_arguments
from ulna.io.srdf import read_srdf
from ulna.io.urdf import read_urdf
from ulna.model.description import Description
from ulna.model.references import matched
from ulna.robots.bundled import BUNDLED


def load_description(
    source: str | Path,
    xacro_args: Mapping[str, object],
    package_dirs: Iterable[str | Path],
    srdf: str | Path | None = None,
) -> tuple[Description, tuple[float, ...] | None]:
    """The description, and for a bundled robot its home configuration."""
    _check("source", source, "a name, a path or URDF text")
    if srdf is not None:
        _check("srdf", srdf, "a path or SRDF text")
    if isinstance(package_dirs, (str, Path)) or not isinstance(package_dirs, Iterable):
        raise InputError("package_dirs", f"{package_dirs!r}; a list of folders is expected")
    if not isinstance(xacro_args, Mapping):
        raise InputError("xacro_args", f"{xacro_args!r}; a dict of names and values is expected")
    folders = list(package_dirs)
    description, home = _described(source, xacro_args, folders)
    if srdf is None:
        return description, home
    document = expanded(open_document("srdf", srdf, "SRDF"), {}, folders)
    semantics = matched(read_srdf(document.text, document.source), description)
    for first in semantics.warnings[:1]:
        count = len(semantics.warnings)
        more = f" ({count} such sentences: robot.srdf.warnings)" if count > 1 else ""
        warnings.warn(first + more, DescriptionWarning, stacklevel=3)
    return replace(description, srdf=semantics), home


def _check(argument: str, source: object, expected: str) -> None:
    if not isinstance(source, (str, Path)):
        raise InputError(argument, f"{type(source).__name__}; {expected} is expected")
    if isinstance(source, str) and not source.strip():
        raise InputError(argument, f"an empty string; {expected} is expected")


def _described(
    source: str | Path, xacro_args: Mapping[str, object], package_dirs: list[str | Path]
) -> tuple[Description, tuple[float, ...] | None]:
    if isinstance(source, str) and source in BUNDLED:
        bundled = BUNDLED[source]
        refuse_arguments(source, xacro_args)
        return read_urdf(bundled.text(), bundled.file), bundled.home
    try:
        document = expanded(open_document("source", source, "URDF"), xacro_args, package_dirs)
    except FileError as error:
        path = Path(source)
        if error.message == "no such file" and path.parent == Path() and not path.suffix:
            hint = f"; nor is it a bundled robot{did_you_mean(str(path), BUNDLED)}"
            raise FileError(error.path, f"no such file{hint}") from None
        raise
    return read_urdf(document.text, document.source), None
