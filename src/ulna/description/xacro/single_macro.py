"""Expands a xacro document that only defines a macro, by calling it.

The course's ``franka_robot.urdf`` is such a document.
"""

import re

from lxml import etree

from ulna.errors import DescriptionError, did_you_mean

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
