"""Starts the child process that expands a xacro document, passes it files, and ends it in time."""

import json
import subprocess
from typing import IO, Any

from ulna.description.child_process import child_process, last_words, printable, program_of
from ulna.description.readable import OutsideError, Readable
from ulna.description.xml import LONGEST
from ulna.errors import DescriptionError

_LONGEST_MESSAGE = 7 * LONGEST  # of the child: a text of that length, each letter written as \u0000
_START = program_of("ulna.description.xacro.child.main")


class _DiedError(Exception):
    """The child ended, or sent an invalid message."""


def expanded_by_child(request: dict[str, Any], readable: Readable, memory: int, seconds: float, source: str) -> dict[str, Any]:
    """The reply of the child to a request: ``urdf``, and as ``asked`` the names of arguments that it looked up.

    Raises:
        DescriptionError: The document fails, runs too long or reaches outside.
    """
    with child_process(_START, memory, seconds) as (child, late):
        left_out: dict[str, str] = {}
        try:
            left_out = _received(child)["left_out"]
            done = _served(child, {**request, "longest": LONGEST}, readable)
        except (_DiedError, OSError, ValueError, KeyError, TypeError):
            child.kill()
            words = last_words(child, child.communicate()[1])
            if late.is_set():
                raise DescriptionError(f"xacro: no end within {seconds:g} s; expansion stopped", source) from None
            limits = _limits(memory, seconds, left_out)
            raise DescriptionError(f"xacro: the expansion died ({words}); {limits}", source) from None
    if "error" in done:
        raise DescriptionError(f"xacro: {printable(str(done['error']))}", source)
    return done


def _served(child: subprocess.Popen, request: dict[str, Any], readable: Readable) -> dict[str, Any]:
    """The child's last message, after the request and all files that it needs."""
    _send(child, request)
    while True:
        message = _received(child)
        if isinstance(message.get("urdf"), str) and isinstance(message.get("asked"), list):
            return message
        if "error" in message:
            return message
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
    sink.write(json.dumps(message).encode() + b"\n")
    sink.flush()


def _received(child: subprocess.Popen) -> dict[str, Any]:
    source: IO[bytes] = child.stdout  # pyright: ignore[reportAssignmentType]
    line = source.readline(_LONGEST_MESSAGE)
    message = json.loads(line) if line.endswith(b"\n") else None
    if not isinstance(message, dict):
        raise _DiedError
    return message


def _limits(memory: int, seconds: float, left_out: dict[str, str]) -> str:
    said = f"its limits are {seconds:g} s" + ("" if "RLIMIT_AS" in left_out else f" and {memory >> 30} GiB")
    could_not = ", ".join(f"{name} ({why})" for name, why in left_out.items())
    return said + (f"; this system has not granted {could_not}" if could_not else "")
