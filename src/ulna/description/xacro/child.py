"""The child process that expands a xacro document: a JSON request on standard input, a JSON answer on standard output."""

import codecs
import io
import json
import os
import re
import sys
import warnings
import xml.dom.minidom
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Any
from urllib.parse import unquote

import xacro
import yaml
from xacro import substitution_args

from ulna.description.xacro.audit_hook import Fence, FenceError
from ulna.description.xml import LONGEST

_ENCODINGS = ("ascii", "iso-8859-1", "iso-8859-15", "cp1252", "utf-16", "utf-32", "utf-8-sig", "unicode_escape")


class _Arguments(dict):
    """The arguments given, which notes the names that a document asks for."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def main() -> None:
    """Expand and answer; whatever goes wrong is a sentence in the answer."""
    request = json.load(sys.stdin)
    _limit(request["memory"], request["seconds"])
    try:
        answer = _expand(request)
    except RecursionError:
        answer = {"error": "a macro calls itself without end"}
    except MemoryError:
        answer = {"error": "out of memory"}
    except Exception as error:  # xacro raises whatever the document's expressions raise
        answer = {"error": _sentence(error)}
    json.dump(answer, sys.stdout)


def _sentence(error: BaseException) -> str:
    """What went wrong, once, in one line."""
    inner: BaseException | None = error
    while inner is not None:
        if isinstance(inner, MemoryError):
            return "out of memory " + " ".join(str(error).split())
        if isinstance(inner, FenceError):
            return str(inner)
        inner = getattr(inner, "exc", None) or inner.__cause__ or inner.__context__
    text = re.sub(r"<class '[\w.]+'>: ", "", " ".join(str(error).split()))
    half = len(text) // 2
    if len(text) % 2 == 1 and text[:half] == text[half + 1 :]:
        text = text[:half]
    return re.sub(r" \[Errno \d+\].*", "", text) or type(error).__name__


def _limit(memory: int, seconds: float) -> None:
    try:
        import resource
    except ImportError:  # Windows: the parent's time limit alone
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))


def _expand(request: dict) -> dict[str, Any]:
    path = None if request["folder"] is None else Path(request["folder"]) / request["file"]
    sys.stderr = io.StringIO()  # a document may print without end
    fence = Fence(None if path is None else path.parent, request["package_dirs"])
    _teach_xacro(fence, path)
    arguments = _Arguments(request["arguments"])
    document: Any = xml.dom.minidom.parseString(request["text"])  # noqa: S318 - the parent parsed it first
    _load_what_is_imported_late()
    fence.close()
    xacro.process_doc(document, mappings=arguments)
    text = document.toprettyxml(indent="  ")
    if len(text) > LONGEST:
        raise ValueError(f"expands to {len(text) / 1e6:.0f} MB; up to {LONGEST / 1e6:.0f} MB are read")
    return {"urdf": text, "asked": sorted(arguments.asked)}


def _teach_xacro(fence: Fence, path: Path | None) -> None:
    """Where packages lie (xacro asks ament, which only ROS 2 has), addresses as file names, and no Python but what it offers."""
    beside, evaluated = xacro.abs_filename_spec, xacro.safe_eval

    def safe_eval(expression: str, names: dict, more: dict | None = None) -> Any:
        for name in _names(compile(expression.strip(), "<expression>", "eval")):
            if name.startswith("__"):  # xacro looks at the outermost only
                raise FenceError(f"uses the invalid name {name}")
        return evaluated(expression, names, more)

    def located(spec: str) -> str:
        scheme, _, rest = str(spec).partition("://")
        if scheme == "package":
            name, _, inside = unquote(rest).partition("/")
            return os.path.join(fence.find(name), inside)  # noqa: PTH118 - text in, text out
        return unquote(rest) if scheme == "file" else beside(spec)

    xacro.abs_filename_spec, xacro.safe_eval = located, safe_eval
    substitution_args._eval_find = fence.find  # noqa: SLF001
    substitution_args._eval_dict["find"] = fence.find  # noqa: SLF001
    without_builtins = {"__builtins__": {}}
    substitution_args.eval = lambda text, _, names: eval(text, without_builtins, names)  # noqa: S307  # pyright: ignore[reportAttributeAccessIssue]
    if path is not None:
        os.chdir(path.parent)
        xacro.init_stacks(str(path))
        xacro.substitution_args_context["filename"] = str(path)


def _names(code: CodeType) -> Iterator[str]:
    """The names in an expression, those within comprehensions and functions too."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _load_what_is_imported_late() -> None:
    """What the expansion would import, before imports end."""
    warnings.simplefilter("ignore")  # to show one, Python opens files
    yaml.safe_load("a: [1, 2.0, 2001-01-01, !!binary aa==]")
    for name in _ENCODINGS:
        codecs.lookup(name)


if __name__ == "__main__":
    main()
