"""Finds the SRDF of a robot beside its URDF, as in example-robot-data and in MoveIt's config packages."""

import os
import re
import warnings
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

from ulna.description.document import Document, expanded
from ulna.description.file_bytes import regular_file_bytes
from ulna.description.packages import package_folders
from ulna.description.references import matched
from ulna.description.robot_description import Description
from ulna.description.semantic import Srdf
from ulna.description.srdf import read_srdf
from ulna.description.xml import LONGEST
from ulna.errors import DescriptionError, DescriptionWarning, InputError, listed

_ENDINGS = (".srdf", ".srdf.xacro")
_MOST_FILES = 100  # that are looked at
_PACKAGE_NAME = re.compile(r"\w[\w.-]*")


def srdf_beside(document: Document, folder: Path, description: Description) -> Srdf:
    """The SRDF beside a URDF in a folder, its references checked. Empty if no file fits, or several do and none is preferred.

    1. Files are looked for in the URDF's folder, in ``srdf`` beside that folder, and in ``config`` of the packages
       ``NAME_moveit_config``: NAME is that of the robot, of the URDF, or of its package without ``_description``.
    2. A file fits if its ``<robot name=...>`` is the robot's, and the robot has all links that it names.
    3. Of those that fit, the one that is called like the URDF is taken, else the one that is called like the robot, else the
       only one. If there are others only, none is taken, with a ``DescriptionWarning`` that names them.
    """
    stem, fits, passed_over = _stem(document.file), {}, []
    likely = (stem, description.name)
    for path in islice(_files(folder, stem, document.package_dirs, description.name), _MOST_FILES):
        try:
            srdf = _read(path, document.package_dirs, description)
        except (OSError, DescriptionError, InputError) as error:
            if _stem(path.name) in likely:
                passed_over.append(f"{path} lies beside the URDF and is not used: {error}")
        else:
            fits.setdefault(_stem(path.name), replace(srdf, found_at=str(path)))
    taken = next((fits[name] for name in likely if name in fits), None)
    if taken is None and len(fits) > 1:
        files = listed([srdf.found_at for srdf in fits.values()])
        advice = "none is used; srdf= names one (--srdf), srdf=False refuses them (--no-srdf)"
        warnings.warn(f"{len(fits)} SRDFs beside {document.file} fit it ({files}); {advice}", DescriptionWarning, stacklevel=4)
    elif taken is None and fits:
        (taken,) = fits.values()
    return taken or Srdf(passed_over=tuple(passed_over))


def _stem(file: str) -> str:
    """The name of a file without its endings: ``arm`` of ``arm.urdf.xacro`` and ``arm.srdf``."""
    return re.sub(r"(\.(urdf|srdf|xacro))+$", "", file)


def _files(folder: Path, stem: str, package_dirs: tuple[Path, ...], robot: str) -> Iterator[Path]:
    """The files that may be the SRDF, each once, a plain one before one that is expanded."""
    above, seen = folder.resolve(), set()
    package = next((each.name for each in (above, above.parent) if each.name.endswith("_description")), "")
    names = dict.fromkeys(name for name in (robot, stem, package.removesuffix("_description")) if _PACKAGE_NAME.fullmatch(name))
    configs = (f for name in names for f in package_folders(f"{name}_moveit_config", folder, package_dirs))
    for place in (folder, above.parent / "srdf", *(config / "config" for config in configs)):
        try:
            files = [file for file in sorted(place.iterdir()) if file.name.endswith(_ENDINGS)] if place.is_dir() else []
        except OSError:  # a folder that cannot be listed
            files = []
        for file in sorted(files, key=lambda file: file.suffix == ".xacro"):
            if (resolved := os.path.realpath(file)) not in seen:
                seen.add(resolved)
                yield file


def _read(path: Path, package_dirs: tuple[Path, ...], description: Description) -> Srdf:
    """The SRDF in a file."""
    document = Document(regular_file_bytes(path, LONGEST), path.name, path.parent, package_dirs, path.name)
    name = document.root.get("name", "")
    if "$" not in name:  # else it is known once it is expanded
        _refuse_other(name, path, description)
    srdf = read_srdf(expanded(document, {}))
    _refuse_other(srdf.name, path, description)
    known = {link.name for link in description.links}
    missing = [link for link in dict.fromkeys(_links(srdf)) if link not in known]
    if missing:
        raise DescriptionError(f"it names links that the robot lacks: {listed(missing)}", path.name)
    return matched(srdf, description)


def _refuse_other(name: str, path: Path, description: Description) -> None:
    if name != description.name:
        raise DescriptionError(f"it is of the robot {name!r}, not of {description.name!r}", path.name)


def _links(srdf: Srdf) -> Iterator[str]:
    """The links that an SRDF names."""
    for pair in srdf.disabled_collisions:
        yield from (pair.link_a, pair.link_b)
    for group in srdf.groups:
        yield from group.links
        for ends in group.chains:
            yield from ends
    for effector in srdf.end_effectors:
        yield effector.parent_link
    for joint in srdf.virtual_joints:
        yield joint.child_link
    yield from srdf.unchecked_links
    for enabled in srdf.enabled_collisions:
        yield from enabled
