"""xacro in, URDF text out. A xacro file is a program, so it runs in a child process, with limits of time and memory."""

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from lxml import etree

from ulna.errors import DescriptionError, did_you_mean
from ulna.io.xml import parse

NAMESPACES = ("http://www.ros.org/wiki/xacro", "http://ros.org/wiki/xacro", "http://wiki.ros.org/xacro")
TIME_LIMIT_S = 20.0
MEMORY_LIMIT_BYTES = 2 << 30


def is_xacro(root: etree._Element) -> bool:
    """True if a document uses xacro: elements of its namespace, or its expressions with the namespace declared."""
    if any(isinstance(e.tag, str) and etree.QName(e).namespace in NAMESPACES for e in root.iter()):
        return True
    declared = any(uri in NAMESPACES for uri in root.nsmap.values())
    return declared and any("${" in str(v) or "$(" in str(v) for e in root.iter() for v in e.attrib.values())


def expand_xacro(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, str], package_dirs: Iterable[str | Path]
) -> bytes:
    """The URDF that a xacro document stands for.

    A document that only defines one macro, as the course's ``franka_robot.urdf`` does, is expanded by calling it; its parameters
    without a default come from ``xacro_args``.

    Raises:
        DescriptionError: The document fails, runs too long, or defines several macros and calls none.
    """
    root = parse(text, source)
    arguments = {str(key): str(value) for key, value in xacro_args.items()}
    if _only_defines(root):
        _call_the_macro(root, source, arguments)
    request = {
        "text": etree.tostring(root, encoding="unicode"),
        "folder": None if folder is None else str(folder.resolve()),
        "arguments": arguments,
        "package_dirs": [str(Path(p).resolve()) for p in package_dirs],
        "memory": MEMORY_LIMIT_BYTES,
        "seconds": TIME_LIMIT_S,
    }
    command = [sys.executable, "-P", "-m", "ulna.io.xacro_child"]  # -P: nothing of the working folder is imported
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    try:
        child = subprocess.run(  # noqa: S603 - this Python, our own module
            command, input=json.dumps(request).encode(), capture_output=True, env=environment, timeout=TIME_LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise DescriptionError(f"xacro: no end within {TIME_LIMIT_S:g} s; expansion stopped", source) from None
    try:
        answer = json.loads(child.stdout)
    except ValueError:
        last = child.stderr.decode(errors="replace").strip().splitlines()[-1:] or [f"exit status {child.returncode}"]
        raise DescriptionError(
            f"xacro: the expansion died ({last[0]}); its limits are {TIME_LIMIT_S:g} s and 2 GiB", source
        ) from None
    if "error" in answer:
        raise DescriptionError(f"xacro: {answer['error']}", source)
    return answer["urdf"].encode()


def _only_defines(root: etree._Element) -> bool:
    """True if no link, joint or macro call stands at the top: only definitions."""
    definitions = {"macro", "property", "arg", "include"}
    children = [etree.QName(e) for e in root if isinstance(e.tag, str)]
    ours = [name for name in children if name.namespace in NAMESPACES]
    others = [name for name in children if name.namespace not in NAMESPACES and name.localname in ("link", "joint")]
    return not others and any(n.localname == "macro" for n in ours) and all(n.localname in definitions for n in ours)


def _call_the_macro(root: etree._Element, source: str, arguments: dict[str, str]) -> None:
    """Append a call of the document's one macro, and take its parameters out of the arguments."""
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
    from xacro import parse_macro_arg

    has_default = {}
    while text.strip():
        name, default, text = parse_macro_arg(text)
        if not name.startswith("*"):
            has_default[name] = default is not None
    return has_default
