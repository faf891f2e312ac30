"""Finds the SRDF of a robot near its URDF, as in example-robot-data and in MoveIt's config packages."""

import logging
import os
import re
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

from ulna.description.document import Document, expanded, shared_arguments
from ulna.description.file_bytes import regular_file_bytes
from ulna.description.packages import folders_above, package_folders
from ulna.description.readable import Readable
from ulna.description.references import matched
from ulna.description.robot_description import Description
from ulna.description.semantic import Srdf
from ulna.description.srdf import read_srdf
from ulna.description.xml import parse
from ulna.errors import DescriptionError, DescriptionWarning, InputError, count_of, listed

_ENDINGS = (".srdf", ".srdf.xacro")
_MAX_FILES = 20  # limit of files that are read
_MAX_NAMES = 10_000  # compared names of one folder
_MAX_BYTES = 8_000_000  # of one file; MoveIt's largest have some hundred thousand
_MAX_SECONDS_EACH, _MAX_SECONDS = 5.0, 10.0  # for the expansion of one xacro file, and in total
_PACKAGE_NAME = re.compile(r"\w[\w.-]*")
_log = logging.getLogger(__name__)


def srdf_beside(document: Document, folder: Path, description: Description, xacro_args: Mapping[str, object]) -> Srdf:
    """The checked SRDF near a URDF; empty if no file fits, or several fit without a preferred one.

    1. The search covers the URDF's folder, the folder ``srdf`` next to it if that is in the URDF's package, and ``config`` of a
       package ``NAME_moveit_config``. The ``package.xml`` of the latter must have that name and depend on the URDF's package.
       NAME is the name of the robot, of the URDF, or of its package without ``_description``. A link may lead only into the
       URDF's folder, its package, or such a package.
    2. A file fits if its ``<robot name=...>`` is the robot's, and the robot has all links that it names.
    3. The fitting file with the URDF's name is preferred, then the one with the robot's name, then the only one. Several others
       are not used.

    A file in use is logged. An unused file whose folder or name suggests that it was meant is a ``DescriptionWarning``.
    """
    found = _Candidates(document, folder, (_stem(document.file), description.name))
    fits: dict[str, Srdf] = {}
    n_unread = 0
    end = time.monotonic() + _MAX_SECONDS
    for rank, path in found.files():
        if time.monotonic() > end:
            n_unread += 1
            continue
        try:
            srdf = replace(_read(path, document.package_dirs, description, xacro_args), found_at=str(path))
        except (OSError, DescriptionError, InputError) as error:
            if rank < len(found.likely):
                found.pass_over(f"{path} is next to the URDF and is not used: {error}")
        else:
            if rank < len(found.likely):
                return _taken(srdf, found, document)
            fits.setdefault(_stem(path.name), srdf)
    if n_unread:
        more, are = count_of(n_unread, "more file"), "is" if n_unread == 1 else "are"
        found.pass_over(f"{more} next to {document.file} {are} not read, after {_MAX_SECONDS:g} s")
    advice = "none is used; srdf= selects one (--srdf), srdf=False ignores them (--no-srdf)"
    if len(fits) == 1 and found.complete and not n_unread:
        return _taken(next(iter(fits.values())), found, document)
    if fits:
        fit = "1 SRDF next to {} matches it" if len(fits) == 1 else f"{len(fits)} SRDFs next to {{}} match it"
        files = listed([srdf.found_at for srdf in fits.values()])
        warnings.warn(f"{fit.format(document.file)} ({files}); {advice}", DescriptionWarning, stacklevel=4)
    return _taken(Srdf(), found, document)


def _taken(srdf: Srdf, found: "_Candidates", document: Document) -> Srdf:
    """The SRDF, after a message about the files used and not used."""
    if srdf.found_at:
        pairs = count_of(len(srdf.disabled_collisions), "pair")
        _log.info("%s is next to %s and is used; it allows contacts of %s of links", srdf.found_at, document.file, pairs)
    for sentence in found.passed_over:
        warnings.warn(sentence, DescriptionWarning, stacklevel=5)
    return replace(srdf, passed_over=tuple(found.passed_over))


def _stem(file: str) -> str:
    """The name of a file without its extensions: ``arm`` of ``arm.urdf.xacro`` and ``arm.srdf``."""
    return re.sub(r"(\.(urdf|srdf|xacro))+$", "", file)


@dataclass
class _Candidates:
    """The files that may be the SRDF of a document.

    Attributes:
        document: The URDF.
        folder: Its folder.
        likely: The possible names of its SRDF, the preferred one first.
        passed_over: Sentences about unused files.
        complete: Whether all files were listed.
    """

    document: Document
    folder: Path
    likely: tuple[str, ...]
    passed_over: list[str] = field(default_factory=list)
    complete: bool = True

    def pass_over(self, sentence: str) -> None:
        if len(self.passed_over) < _MAX_FILES:
            self.passed_over.append(sentence)

    def files(self) -> list[tuple[int, Path]]:
        """Each file once with its rank, the index of its name in ``likely``; plain files precede xacro files."""
        readable, seen, found = Readable(self.folder, ()), set(), []
        for place in self._places(readable):
            for file in self._listed(place):
                resolved = os.path.realpath(file)
                if resolved in seen:
                    continue
                seen.add(resolved)
                stem = _stem(file.name)
                rank = self.likely.index(stem) if stem in self.likely else len(self.likely)
                if readable.admits(file):
                    found.append((rank, file))
                else:
                    self.pass_over(f"{file} is a link to a file outside the URDF's folder and package, so it is not used")
        found.sort(key=lambda one: one[0])
        if len(found) > _MAX_FILES:
            self.complete = False
            self.pass_over(f"{len(found)} SRDFs are next to {self.document.file}; only {_MAX_FILES} of them are read")
        return found[:_MAX_FILES]

    def _places(self, readable: Readable) -> Iterator[Path]:
        """The folders that may contain the SRDF."""
        above = self.folder.resolve()
        yield self.folder
        package = next((path for path in folders_above(self.folder) if (path / "package.xml").is_file()), None)
        if package is not None and above != package:
            yield above.parent / "srdf"
        name = "" if package is None else _manifest(package)[0]
        stem, robot = self.likely
        names = dict.fromkeys(each for each in (robot, stem, name.removesuffix("_description")) if _PACKAGE_NAME.fullmatch(each))
        given = {each for one in names for each in package_folders(f"{one}_moveit_config", None, self.document.package_dirs)}
        for config_name in (f"{one}_moveit_config" for one in names):
            for config in dict.fromkeys(package_folders(config_name, self.folder, self.document.package_dirs)):
                if not (config / "config").is_dir():
                    continue
                reason = self._refusal(config, config_name, name) or readable.admit_package(config, given=config in given)
                if reason:
                    self.pass_over(f"{config} {reason}, so no SRDF in it is used")
                else:
                    yield config / "config"

    def _refusal(self, config: Path, config_name: str, package: str) -> str:
        """The reason why a folder is not the configuration of the URDF's package; empty if it is."""
        name, depends = _manifest(config)
        if name != config_name:
            return f"has no package.xml that names it {config_name}"
        if not package:
            return f"cannot depend on the package of {self.document.file}, which is in none"
        return "" if package in depends else f"does not depend on {package}, the package of {self.document.file}"

    def _listed(self, place: Path) -> list[Path]:
        """The files in a folder with an SRDF's extension, sorted by name, plain ones first."""
        try:
            with os.scandir(place) as entries:
                names = [entry.name for entry in islice(entries, _MAX_NAMES + 1)]
        except OSError:  # the folder is missing, or cannot be listed
            return []
        if len(names) > _MAX_NAMES:
            self.complete = False
            self.pass_over(f"{place} has more than {_MAX_NAMES} files, of which not all are considered")
        files = sorted(place / name for name in names[:_MAX_NAMES] if name.endswith(_ENDINGS))
        return sorted(files, key=lambda file: file.suffix == ".xacro")


def _manifest(package: Path) -> tuple[str, set[str]]:
    """The name and the dependencies in a folder's ``package.xml``; empty if it cannot be read."""
    try:
        root = parse(regular_file_bytes(package / "package.xml", _MAX_BYTES), "package.xml")
    except (OSError, ValueError):
        return "", set()
    children = [(str(child.tag), (child.text or "").strip()) for child in root]
    name = next((text for tag, text in children if tag == "name"), "")
    return name, {text for tag, text in children if tag.endswith("depend") and tag not in ("buildtool_depend", "test_depend")}


def _read(path: Path, package_dirs: tuple[Path, ...], description: Description, xacro_args: Mapping[str, object]) -> Srdf:
    """The SRDF in a file; a xacro file gets the URDF's values for the arguments that it defines."""
    content = regular_file_bytes(path, _MAX_BYTES)
    if len(content) > _MAX_BYTES:
        raise DescriptionError(f"has more than {_MAX_BYTES // 1_000_000} MB; srdf= reads it (--srdf)", path.name)
    document = Document(content, path.name, path.parent, package_dirs, path.name)
    name = document.root.get("name", "")
    if "$" not in name:  # otherwise the name is known only after the expansion
        _refuse_other(name, path, description)
    srdf = read_srdf(expanded(document, shared_arguments(document, xacro_args), max_seconds=_MAX_SECONDS_EACH))
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
