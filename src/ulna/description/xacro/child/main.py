"""Reads a request, confines its process, expands the document.

It replaces two parts of the package xacro: the evaluation of expressions (``expressions``), and the reading of files (by the
parent process).
"""

import io
import json
import os
import re
import sys
import unicodedata
import warnings
import xml.dom.minidom
from types import ModuleType, SimpleNamespace
from typing import Any
from urllib.parse import unquote

import xacro
import yaml
from xacro import substitution_args

from ulna.description.xacro.child.addresses import path_of_address
from ulna.description.xacro.child.confinement import confine
from ulna.description.xacro.child.expressions import evaluate, offer, offer_those_of_xacro
from ulna.description.xacro.child.parent import MAX_SENTENCE, Parent, RefusedError

_LONG_WORD = re.compile(r"(\S{190})\S{10,}")
_MAX_NAMES, _MAX_NAME = 1000, 200  # of argument names sent to the parent, and their length


def main() -> None:
    """Expand, and send the result, or the error as a sentence."""
    parent = Parent(sys.stdin.buffer, sys.stdout.buffer)
    sys.stderr = io.StringIO()  # a document may print without end
    _load_what_is_imported_late()
    limits = json.loads(sys.argv[-1])
    left_out = confine(limits["memory"], limits["seconds"])
    parent.send({"left_out": left_out})
    try:
        parent.send_urdf(*_expanded(parent, parent.receive()))
    except RecursionError:
        parent.send({"error": "a macro calls itself without end"})
    except MemoryError:
        parent.send({"error": "out of memory"})
    except Exception as error:  # noqa: BLE001 - xacro raises whatever the document's expressions raise
        parent.send({"error": _LONG_WORD.sub(r"\1...", _sentence(error)[: 2 * MAX_SENTENCE])[:MAX_SENTENCE]})


def _expanded(parent: Parent, request: dict) -> tuple[bytes, list[str]]:
    """The URDF in UTF-8, and the names of arguments that were looked up."""
    arguments = Arguments(request["arguments"])
    _teach_xacro(parent, arguments, request["file"], request["folder"])
    document: Any = xml.dom.minidom.parseString(request["text"])  # noqa: S318 - the parent parsed it first
    xacro.process_doc(document, mappings=arguments)
    urdf = document.toprettyxml(indent="  ").encode(errors="surrogatepass")
    longest = request["longest"]
    if len(urdf) > longest:
        raise ValueError(f"expands to {len(urdf) / 1e6:.0f} MB; up to {longest / 1e6:.0f} MB are read")
    return urdf, sorted(name for name in arguments.asked if len(name) <= _MAX_NAME)[:_MAX_NAMES]


def _sentence(error: BaseException) -> str:
    """The error message in one line."""
    inner: BaseException | None = error
    said = " ".join(str(error)[: 2 * MAX_SENTENCE].split())
    while inner is not None:
        if isinstance(inner, MemoryError):
            return f"out of memory {said}"
        if isinstance(inner, RefusedError):
            return str(inner)
        inner = getattr(inner, "exc", None) or inner.__cause__ or inner.__context__
    text = re.sub(r"<class '[\w.]+'>: ", "", said)
    half = len(text) // 2
    if len(text) % 2 == 1 and text[:half] == text[half + 1 :]:
        text = text[:half]
    return re.sub(r" \[Errno \d+\].*", "", text) or type(error).__name__


def _load_what_is_imported_late() -> None:
    """Import the modules of the expansion, before files can no longer be opened."""
    warnings.simplefilter("ignore")  # to show one, Python opens files
    yaml.safe_load("a: [1, 2.0, 2001-01-01, !!binary aa==]")
    xml.dom.minidom.parseString("<a/>").toprettyxml()  # noqa: S318 - our own
    unicodedata.normalize("NFKC", "a")  # names of other alphabets, and "\N{...}" in a text, need it


_USED = {  # of the package xacro: what is replaced, then what is called or read, here and in ``expressions``
    xacro: (
        *("safe_eval", "abs_filename_spec", "glob", "root_dir"),
        *("_global_symbols", "init_stacks", "process_doc", "substitution_args_context"),
        *("NameSpace", "YamlDictWrapper", "YamlListWrapper"),
    ),
    substitution_args: ("_eval", "_eval_find", "_eval_env", "_eval_optenv", "_eval_dirname", "convert_value"),
}


class Arguments(dict):
    """The given arguments, and the names that a document looks up."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def _teach_xacro(parent: Parent, arguments: Arguments, file: str | None, folder: str) -> None:
    """Replace the functions with which xacro evaluates expressions and reads files; relative paths start in ``folder``."""
    missing = [f"{module.__name__}.{name}" for module, names in _USED.items() for name in names if not hasattr(module, name)]
    if missing:
        raise RefusedError(f"this version of the package xacro is not supported (no {missing[0]}); 2.1.1 is")
    for module in _USED:
        _without_python(module, parent)
    beside = xacro.abs_filename_spec
    offer_those_of_xacro(xacro._global_symbols)  # noqa: SLF001
    changed: Any = xacro
    changed.safe_eval = lambda text, names, _=None: evaluate(text, names.__getitem__)
    changed.root_dir = folder  # of $(cwd)
    changed.abs_filename_spec = lambda spec: os.path.join(folder, _located(spec, parent, beside))  # noqa: PTH118 - text
    changed.glob = SimpleNamespace(glob=parent.matching)
    _teach_substitution(parent, arguments)
    if file is not None:
        xacro.init_stacks(file)
        xacro.substitution_args_context["filename"] = file


def _without_python(module: ModuleType, parent: Parent) -> None:
    """Replace ``open`` in a module by requests to the parent, and ``eval``, ``exec`` and ``compile`` by errors."""

    def refused(*_: object, **__: object) -> None:
        raise RefusedError("this version of the package xacro evaluates Python by itself; 2.1.1 does not here")

    vars(module).update(open=parent.open, eval=refused, exec=refused, compile=refused)


def _located(spec: str, parent: Parent, beside) -> str:
    """The path of an address: ``package://``, ``file://``, or relative to the document that names it."""
    scheme, _, rest = str(spec).partition("://")
    if scheme == "package":
        name, _, inside = unquote(rest).partition("/")
        return os.path.join(parent.find(name), inside)  # noqa: PTH118 - text in, text out
    return path_of_address(rest) if scheme == "file" else beside(spec)


def _teach_substitution(parent: Parent, arguments: Arguments) -> None:
    """Replace ``$(find)`` by the parent's reply, ``$(env)`` by the arguments, and ``$(eval)`` by ``evaluate``."""

    def variable(name: str) -> str:
        if name in arguments:
            return arguments[name]
        raise RefusedError(f"$(env {name}): a description reads no environment variables; give {name} in xacro_args")

    def variable_or(name: str, default: str = "") -> str:
        return arguments[name] if name in arguments else default  # noqa: SIM401 - `get` would not note the name

    functions = {"find": offer(parent.find), "env": offer(variable), "optenv": offer(variable_or)}
    functions |= {"arg": offer(lambda name: _converted(arguments[name])), "dirname": offer(_folder)}
    constants = {"true": True, "false": False}

    def named(name: str) -> Any:
        for table in (functions, constants, xacro._global_symbols):  # noqa: SLF001
            if name in table:
                return table[name]
        return _converted(arguments[name])

    changed: Any = substitution_args
    changed._eval_find, changed._eval_env, changed._eval_optenv = parent.find, variable, variable_or  # noqa: SLF001
    changed._eval = lambda text, _: str(evaluate(text, named))  # noqa: SLF001


def _folder() -> str:
    return substitution_args._eval_dirname(xacro.substitution_args_context.get("filename"))  # noqa: SLF001


def _converted(text: str) -> Any:
    return substitution_args.convert_value(text, "auto")
