"""Docstrings as Sphinx wants them: their sections (Args, Returns, Raises ...) as fields, with the types of the source.

The text is plain: bars and stars in it are mathematics (``|v|^2``), not markup; only double backquotes mean something.
"""

import ast
import inspect
import re
import textwrap
from pydoc import locate

from sphinx.ext.napoleon import Config, GoogleDocstring

_SETTINGS = Config(napoleon_use_rtype=False, napoleon_use_param=True)
_UNTOLD = {None, "None", "Any"}


def _process(app, what, name, obj, options, lines):
    text = [_plain(line) for line in lines]
    if what in {"attribute", "property"}:  # in these Napoleon would take what stands before a colon for a type
        owner, _, own = name.rpartition(".")
        kind = type_words(locate(owner), own)
        lines[:] = [f"``{kind}``: {text[0]}", *text[1:]] if kind else text
        return
    lines[:] = GoogleDocstring(text, _SETTINGS, app, what, name, obj, options).lines()
    if what in {"function", "method"}:
        lines[:] = [*_with_types(lines, obj), ""]


def _plain(line):
    """The line with its bars and stars escaped, but for code."""
    parts = re.split(r"(``.*?``)", line)
    return "".join(part if k % 2 else re.sub(r"([|*])", r"\\\1", part) for k, part in enumerate(parts))


def _with_types(lines, function):
    """A ``:type:`` before each parameter that is told, and the type of what is returned, in the words of the source."""
    types = _types(function)
    for line in lines:
        named = re.match(r":param (\w+):", line)
        if named and named[1] in types:
            yield f":type {named[1]}: {types[named[1]]}"
        if line.startswith(".. rubric::"):
            yield from _return_type(types)
        yield line
    if not any(line.startswith(".. rubric::") for line in lines):
        yield from _return_type(types)


def _return_type(types):
    if types.get("return") not in _UNTOLD:
        yield from ("", f":rtype: {types['return']}", "")


def type_words(cls, name):
    """The annotation of an attribute, or of what a property returns, where the class or one of its bases has it; else empty."""
    for base in cls.__mro__:
        for part in source_of(base).body if base.__module__.startswith("ulna.") else ():
            if isinstance(part, ast.AnnAssign) and ast.unparse(part.target) == name:
                return _words(part.annotation)
            if isinstance(part, ast.FunctionDef) and part.name == name and part.returns is not None:
                return _words(part.returns)
    return ""


def fields_without_words(cls):
    """The names of a class's annotated attributes behind which no docstring stands."""
    bodies = [source_of(base).body for base in cls.__mro__ if base.__module__.startswith("ulna.")]
    pairs = [pair for body in bodies for pair in zip(body, [*body[1:], None], strict=True)]
    fields = [(part, behind) for part, behind in pairs if isinstance(part, ast.AnnAssign)]
    return {ast.unparse(part.target) for part, behind in fields if not isinstance(behind, ast.Expr)}


def _types(function):
    tree = source_of(inspect.unwrap(function))
    arguments = [*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs]
    found = {argument.arg: argument.annotation for argument in arguments} | {"return": tree.returns}
    return {name: _words(annotation) for name, annotation in found.items() if annotation is not None}


def source_of(thing):
    """A class or a function as it is written."""
    return ast.parse(textwrap.dedent(inspect.getsource(thing))).body[0]


def _words(annotation):
    """The annotation as it is written, without quotes; a name that ends in a bar would be markup."""
    text = annotation.value if isinstance(annotation, ast.Constant) else ast.unparse(annotation)
    return str(text).replace("'", "").replace("np.bool_", "np.bool")


def setup(app):
    """Read every docstring so."""
    app.connect("autodoc-process-docstring", _process)
    return {"parallel_read_safe": True}
