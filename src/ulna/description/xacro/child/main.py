"""Reads a request, confines its process, expands the document."""

import io
import json
import re
import sys
import unicodedata
import warnings
import xml.dom.minidom
from typing import Any

import xacro
import yaml

from ulna.description.xacro.child.confinement import add_audit_hook, confine
from ulna.description.xacro.child.hooks import Arguments, teach_xacro
from ulna.description.xacro.child.parent import Parent, RefusedError


def main() -> None:
    """Expand, and send the result, or the error as a sentence."""
    parent = Parent(sys.stdin.buffer, sys.stdout.buffer)
    sys.stderr = io.StringIO()  # a document may print without end
    _load_what_is_imported_late()
    limits = json.loads(sys.argv[-1])
    left_out = confine(limits["memory"], limits["seconds"])
    add_audit_hook()
    parent.send({"left_out": left_out})
    try:
        done = _expanded(parent, parent.receive())
    except RecursionError:
        done = {"error": "a macro calls itself without end"}
    except MemoryError:
        done = {"error": "out of memory"}
    except Exception as error:  # noqa: BLE001 - xacro raises whatever the document's expressions raise
        done = {"error": _sentence(error)}
    parent.send(done)


def _expanded(parent: Parent, request: dict) -> dict[str, Any]:
    arguments = Arguments(request["arguments"])
    teach_xacro(parent, arguments, request["file"], request["folder"])
    document: Any = xml.dom.minidom.parseString(request["text"])  # noqa: S318 - the parent parsed it first
    xacro.process_doc(document, mappings=arguments)
    text = document.toprettyxml(indent="  ")
    longest = request["longest"]
    if len(text) > longest:
        raise ValueError(f"expands to {len(text) / 1e6:.0f} MB; up to {longest / 1e6:.0f} MB are read")
    return {"urdf": text, "asked": sorted(arguments.asked)}


def _sentence(error: BaseException) -> str:
    """The error message in one line."""
    inner: BaseException | None = error
    while inner is not None:
        if isinstance(inner, MemoryError):
            return "out of memory " + " ".join(str(error).split())
        if isinstance(inner, RefusedError):
            return str(inner)
        inner = getattr(inner, "exc", None) or inner.__cause__ or inner.__context__
    text = re.sub(r"<class '[\w.]+'>: ", "", " ".join(str(error).split()))
    half = len(text) // 2
    if len(text) % 2 == 1 and text[:half] == text[half + 1 :]:
        text = text[:half]
    return re.sub(r" \[Errno \d+\].*", "", text) or type(error).__name__


def _load_what_is_imported_late() -> None:
    """Import what the expansion needs, before files can no longer be opened."""
    warnings.simplefilter("ignore")  # to show one, Python opens files
    yaml.safe_load("a: [1, 2.0, 2001-01-01, !!binary aa==]")
    xml.dom.minidom.parseString("<a/>").toprettyxml()  # noqa: S318 - our own
    unicodedata.normalize("NFKC", "a")  # names of other alphabets, and "\N{...}" in a text, need it
