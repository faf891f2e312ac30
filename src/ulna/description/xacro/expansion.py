"""Expands xacro to URDF in a child process that may only compute (``xacro.child``), and serves its files.

A document that only defines a macro, as the course's ``franka_robot.urdf`` does, is expanded by calling it.
"""

import json
import math
import re
import subprocess
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from lxml import etree

from ulna.description.child_process import child_process, last_words, printable
from ulna.description.document import NAMESPACES, Document
from ulna.description.file_bytes import json_value
from ulna.description.readable import OutsideError, Readable
from ulna.description.xacro.child.parent import MAX_LINE, MAX_SENTENCE
from ulna.description.xml import LONGEST
from ulna.engine.child_program import program_of
from ulna.errors import DescriptionError, DescriptionWarning, did_you_mean

TIME_LIMIT_S = 20.0
MEMORY_LIMIT_BYTES = 2 << 30
_START = program_of("ulna.description.xacro.child.main")


class _DiedError(Exception):
    """The child ended, or sent an invalid message."""


def expand_xacro(document: Document, xacro_args: Mapping[str, object], max_seconds: float = math.inf) -> bytes:
    """Expand a xacro document to URDF.

    For a document that only defines a macro, the parameters without a default come from ``xacro_args``. Files are read in the
    document's folder, in its package and in its ``package_dirs``. It ends within ``TIME_LIMIT_S``, and within ``max_seconds``.
    """
    root, source = document.root, document.source
    arguments = {str(key): str(value) for key, value in xacro_args.items()}
    if _only_defines(root):
        _call_the_macro(root, source, arguments)
    beside = None if document.folder is None else document.folder.resolve()
    request = {
        "text": etree.tostring(root, encoding="unicode"),
        "file": None if beside is None else str(beside / source),
        "folder": str(beside or Path.cwd()),
        "arguments": arguments,
        "longest": LONGEST,
    }
    readable = Readable(beside, [str(Path(p).resolve()) for p in document.package_dirs])
    expanded = _expanded_by_child(request, readable, source, min(TIME_LIMIT_S, max_seconds))
    declared = {e.get("name", "") for e in root.iter() if isinstance(e.tag, str) and etree.QName(e).localname == "arg"}
    for name in arguments:
        if name not in declared and name not in expanded["asked"]:
            known = sorted(declared | (set(expanded["asked"]) - set(arguments)))
            _warn(f"{source} has no argument {name!r}, so its value in xacro_args has no effect{did_you_mean(name, known)}")
    try:
        expanded["urdf"].decode()
    except UnicodeDecodeError as error:
        raise DescriptionError(f"xacro: expands to text that is not Unicode ({error.reason})", source) from None
    return expanded["urdf"]


def _warn(sentence: str) -> None:
    """Warn of an argument that a document does not define; launch files of makers pass some, which xacro ignores."""
    warnings.warn(sentence, DescriptionWarning, stacklevel=7)


def _expanded_by_child(request: dict[str, Any], readable: Readable, source: str, seconds: float) -> dict[str, Any]:
    """The reply of the child to a request: ``urdf`` as bytes, and ``asked``, the names of looked-up arguments."""
    with child_process(_START, MEMORY_LIMIT_BYTES, seconds) as (child, late):
        left_out: dict[str, str] = {}
        try:
            left_out = _receive(child)["left_out"]
            done = _serve(child, request, readable)
        except (_DiedError, OSError, ValueError, KeyError, TypeError):
            child.kill()
            words = last_words(child, child.communicate()[1])
            if late.is_set():
                raise DescriptionError(f"xacro: not finished within {seconds:g} s; expansion stopped", source) from None
            limits = _limits(MEMORY_LIMIT_BYTES, seconds, left_out)
            raise DescriptionError(f"xacro: the expansion died ({words}); {limits}", source) from None
    if "error" in done:
        raise DescriptionError(f"xacro: {printable(str(done['error'])[:MAX_SENTENCE])}", source)
    return done


def _serve(child: subprocess.Popen, request: dict[str, Any], readable: Readable) -> dict[str, Any]:
    """Serve the child's request and all files that it needs; returns its last message."""
    _send(child, request)
    while True:
        message = _receive(child)
        if "error" in message:
            return message
        if isinstance(message.get("urdf"), int) and isinstance(message.get("asked"), list):
            return {**message, "urdf": _bytes_received(child, message["urdf"])}
        _send(child, _found(message, readable))


def _found(message: dict[str, Any], readable: Readable) -> dict[str, Any]:
    """The reply to a request of the child, or the error."""
    ((kind, name),) = message.items()
    if not isinstance(name, str):
        raise _DiedError
    try:
        if kind == "read":
            return {"text": _text(name, readable)}
        if kind == "find":
            return {"folder": readable.find(name)}
        if kind == "matching":
            return {"files": readable.matching(name)}
    except OutsideError as error:
        return {"refused": str(error)}
    except OSError as error:
        return {"failed": (error.errno or 5, error.strerror or str(error))}
    except ValueError:  # a zero byte, or a lone surrogate
        return {"refused": f"{name!a} is not a file name"}
    raise _DiedError


def _text(path: str, readable: Readable) -> str:
    content = readable.read(path, LONGEST)
    if len(content) > LONGEST:
        raise OutsideError(f"reads {path}, which is longer than the {LONGEST / 1e6:.0f} MB that are read")
    try:
        text = content.decode()
    except UnicodeDecodeError as error:
        raise OutsideError(f"reads {path}, which is not UTF-8 ({error.reason})") from None
    if "<!ENTITY" in text:
        raise OutsideError(f"reads {path}, which declares XML entities; they are refused")
    return text


def _send(child: subprocess.Popen, message: dict[str, Any]) -> None:
    sink: IO[bytes] = child.stdin  # pyright: ignore[reportAssignmentType]
    sink.write(json.dumps(message, ensure_ascii=False).encode(errors="surrogatepass") + b"\n")
    sink.flush()


def _receive(child: subprocess.Popen) -> dict[str, Any]:
    source: IO[bytes] = child.stdout  # pyright: ignore[reportAssignmentType]
    line = source.readline(MAX_LINE)
    message = json_value(line) if line.endswith(b"\n") else None
    if not isinstance(message, dict):
        raise _DiedError
    return message


def _bytes_received(child: subprocess.Popen, n: int) -> bytes:
    source: IO[bytes] = child.stdout  # pyright: ignore[reportAssignmentType]
    received = source.read(n) if 0 <= n <= LONGEST else b""
    if len(received) != n:
        raise _DiedError
    return received


def _limits(memory: int, seconds: float, left_out: dict[str, str]) -> str:
    said = f"its limits are {seconds:g} s" + ("" if "RLIMIT_AS" in left_out else f" and {memory >> 30} GiB")
    could_not = ", ".join(f"{name} ({why})" for name, why in left_out.items())
    return said + (f"; this system has not granted {could_not}" if could_not else "")


_WORD = r"""(?:'[^']*+'|"[^"]*+"|[^\s'"]++)++"""
_DEFAULT = re.compile(rf"\s*([^\s:=]++)\s*+:?=\s*+(?:\^\|?)?(?:\$\{{[^}}]*+\}}|\$\([^)]*+\)|{_WORD}|)(?:\s++|$)(.*)", re.DOTALL)
"""``name:=default``, as the package xacro reads it, but without backtracking, which can take exponential time."""


def _only_defines(root: etree._Element) -> bool:
    """Whether the top level has no link, joint or macro call, only definitions."""
    definitions = {"macro", "property", "arg", "include"}
    children = [etree.QName(e) for e in root if isinstance(e.tag, str)]
    ours = [name for name in children if name.namespace in NAMESPACES]
    others = [name for name in children if name.namespace not in NAMESPACES and name.localname in ("link", "joint")]
    return not others and any(n.localname == "macro" for n in ours) and all(n.localname in definitions for n in ours)


def _call_the_macro(root: etree._Element, source: str, arguments: dict[str, str]) -> None:
    """Append a call of the document's one macro, and remove its parameters from the arguments."""
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
    """The parameters of a macro, and whether each has a default; blocks (``*name``) are omitted."""
    has_default = {}
    while text.strip():
        default = _DEFAULT.match(text)
        name, text = (default[1], default[2]) if default else [*text.split(None, 1), ""][:2]
        if not name.startswith("*"):
            has_default[name] = default is not None
    return has_default
