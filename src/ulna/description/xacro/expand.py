"""Expands xacro to URDF text, in a child process that may only compute."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from lxml import etree

from ulna.description.readable import Readable
from ulna.description.xacro.single_macro import NAMESPACES, call_the_macro, only_defines
from ulna.description.xml import parse
from ulna.errors import DescriptionError, InputError, did_you_mean

TIME_LIMIT_S = 20.0
MEMORY_LIMIT_BYTES = 2 << 30


def is_xacro(root: etree._Element) -> bool:
    """True if a document uses xacro: elements of its namespace, or its expressions with the namespace declared."""
    if any(isinstance(e.tag, str) and etree.QName(e).namespace in NAMESPACES for e in root.iter()):
        return True
    declared = any(uri in NAMESPACES for uri in root.nsmap.values())
    return declared and any("${" in str(v) or "$(" in str(v) for e in root.iter() for v in e.attrib.values())


def expand_xacro(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]
) -> bytes:
    """The URDF that a xacro document expands to.

    A document that only defines one macro, as the course's ``franka_robot.urdf`` does, is expanded by calling it; its parameters
    without a default come from ``xacro_args``. Files are read in the document's folder, in its package and in ``package_dirs``.

    Raises:
        DescriptionError: The document fails, runs too long, reaches outside, or defines several macros and calls none.
        InputError: It has no argument of a name in ``xacro_args``.
    """
    from ulna.description.xacro.process import expanded_by_child  # noqa: PLC0415 - plain URDF needs no child process

    root = parse(text, source)
    arguments = {str(key): str(value) for key, value in xacro_args.items()}
    if only_defines(root):
        call_the_macro(root, source, arguments)
    beside = None if folder is None else folder.resolve()
    request = {
        "text": etree.tostring(root, encoding="unicode"),
        "file": None if beside is None else str(beside / source),
        "folder": str(beside or Path.cwd()),
        "arguments": arguments,
    }
    readable = Readable(beside, [str(Path(p).resolve()) for p in package_dirs])
    expanded = expanded_by_child(request, readable, MEMORY_LIMIT_BYTES, TIME_LIMIT_S, source)
    declared = {e.get("name", "") for e in root.iter() if isinstance(e.tag, str) and etree.QName(e).localname == "arg"}
    for name in arguments:
        if name not in declared and name not in expanded["asked"]:
            known = sorted(declared | (set(expanded["asked"]) - set(arguments)))
            raise InputError("xacro_args", f"{source} has no argument {name!r}{did_you_mean(name, known)}")
    try:
        return expanded["urdf"].encode()
    except UnicodeEncodeError as error:
        raise DescriptionError(f"xacro: expands to text that is not Unicode ({error.reason})", source) from None
