"""xacro in, URDF text out. A xacro file is a program, so it runs in a child process, with limits of time and memory."""

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from lxml import etree

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
    """The URDF that a xacro document stands for.

    A document that only defines one macro, as the course's ``franka_robot.urdf`` does, is expanded by calling it; its parameters
    without a default come from ``xacro_args``. Files are read in the document's folder, in its package and in ``package_dirs``.

    Raises:
        DescriptionError: The document fails, runs too long, reaches outside, or defines several macros and calls none.
        InputError: It has no argument of a name in ``xacro_args``.
    """
    root = parse(text, source)
    arguments = {str(key): str(value) for key, value in xacro_args.items()}
    if only_defines(root):
        call_the_macro(root, source, arguments)
    request = {
        "text": etree.tostring(root, encoding="unicode"),
        "file": source,
        "folder": None if folder is None else str(folder.resolve()),
        "arguments": arguments,
        "package_dirs": [str(Path(p).resolve()) for p in package_dirs],
        "memory": MEMORY_LIMIT_BYTES,
        "seconds": TIME_LIMIT_S,
    }
    answer = _asked(request, source)
    declared = {e.get("name", "") for e in root.iter() if isinstance(e.tag, str) and etree.QName(e).localname == "arg"}
    for name in arguments:
        if name not in declared and name not in answer["asked"]:
            known = sorted(declared | (set(answer["asked"]) - set(arguments)))
            raise InputError("xacro_args", f"{source} has no argument {name!r}{did_you_mean(name, known)}")
    return answer["urdf"].encode()


def _asked(request: dict, source: str) -> dict:
    """The answer of the child process."""
    command = [sys.executable, "-P", "-m", "ulna.description.xacro.child"]  # -P: nothing of the working folder is imported
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONUTF8": "1"}
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
    return answer
