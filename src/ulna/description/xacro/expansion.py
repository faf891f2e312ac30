"""Expands xacro to URDF text, in a child process that may only compute.

A document that only defines a macro, as the course's ``franka_robot.urdf`` does, is expanded by calling it.
"""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from lxml import etree

from ulna.description.readable import Readable
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


NAMESPACES = ("http://www.ros.org/wiki/xacro", "http://ros.org/wiki/xacro", "http://wiki.ros.org/xacro")
_WORD = r"""(?:'[^']*+'|"[^"]*+"|[^\s'"]++)++"""
_DEFAULT = re.compile(rf"\s*([^\s:=]++)\s*+:?=\s*+(?:\^\|?)?(?:\$\{{[^}}]*+\}}|\$\([^)]*+\)|{_WORD}|)(?:\s++|$)(.*)", re.DOTALL)
"""``name:=default``, as the package xacro reads it; but without backtracking, which can take exponential time."""


def only_defines(root: etree._Element) -> bool:
    """True if there is no link, joint or macro call at the top level, only definitions."""
    definitions = {"macro", "property", "arg", "include"}
    children = [etree.QName(e) for e in root if isinstance(e.tag, str)]
    ours = [name for name in children if name.namespace in NAMESPACES]
    others = [name for name in children if name.namespace not in NAMESPACES and name.localname in ("link", "joint")]
    return not others and any(n.localname == "macro" for n in ours) and all(n.localname in definitions for n in ours)


def call_the_macro(root: etree._Element, source: str, arguments: dict[str, str]) -> None:
    """Append a call of the document's one macro, and take its parameters out of the arguments.

    Raises:
        DescriptionError: There are several macros, or a parameter is missing or unknown.
    """
    macros = [e for e in root if isinstance(e.tag, str) and etree.QName(e).localname == "macro"]
    names = [e.get("name", "") for e in macros]
    if len(macros) != 1:
        message = f"xacro: defines the macros {', '.join(names)} and calls none; add a call such as <xacro:{names[0]}/>"
        raise DescriptionError(message, source, macros[0].sourceline)
    has_default = _parameters(macros[0].get("params", ""))
    given = {key: arguments.pop(key) for key in list(arguments) if key in has_default}
    missing = [name for name, default in has_default.items() if not default and name not in given]
    if missing:
        message = f"xacro: only defines the macro {names[0]!r}; to call it, give {', '.join(missing)} in xacro_args"
        raise DescriptionError(message, source, macros[0].sourceline)
    if arguments and not any(etree.QName(e).localname == "arg" for e in root if isinstance(e.tag, str)):
        unknown = next(iter(arguments))
        message = f"xacro: macro {names[0]!r} has no parameter {unknown!r}{did_you_mean(unknown, has_default)}"
        raise DescriptionError(message, source)
    macro_namespace = etree.QName(macros[0]).namespace
    root.append(root.makeelement(f"{{{macro_namespace}}}{names[0]}", given))


def _parameters(text: str) -> dict[str, bool]:
    """The parameters of a macro, and for each whether it has a default; blocks (``*name``) are left out."""
    has_default = {}
    while text.strip():
        default = _DEFAULT.match(text)
        name, text = (default[1], default[2]) if default else [*text.split(None, 1), ""][:2]
        if not name.startswith("*"):
            has_default[name] = default is not None
    return has_default
