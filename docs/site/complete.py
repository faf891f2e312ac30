"""Refuses a reference that leaves a public name out.

Public is what stands in ``ulna.__all__``, every class that a user reaches from there through an annotation (what a method
returns, what an attribute holds), and every attribute and method of these that has no underscore in front.
"""

import dataclasses
import enum
import inspect
import re
import sys
import typing
from functools import cached_property

from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

import ulna
import ulna.collision.checker
import ulna.ik.search

_log = logging.getLogger(__name__)


def public_classes():
    """The public classes by the name under which the reference has them."""
    waiting = [getattr(ulna, name) for name in ulna.__all__]
    seen = set()
    while waiting:
        thing = waiting.pop()
        if thing in seen or not thing.__module__.startswith("ulna.") or thing.__name__.startswith("_"):
            continue
        seen.add(thing)
        waiting += _reached_from(thing)
    return {public_name(one): one for one in seen if inspect.isclass(one)}


def public_name(thing):
    """The one path by which a user imports it: from ``ulna`` itself where that has it."""
    return f"ulna.{thing.__name__}" if thing.__name__ in ulna.__all__ else f"{thing.__module__}.{thing.__name__}"


def public_members(cls):
    """The names of a class's attributes and methods that a user may touch, those of its bases in this library too."""
    own = [base for base in cls.__mro__ if base.__module__.startswith("ulna.")]
    names = {name for base in own for name in [*vars(base), *vars(base).get("__annotations__", {})] if not name.startswith("_")}
    return sorted(names)


def in_order(cls):
    """The same, constructors and fields first, in the order of the source."""
    order = [name for base in cls.__mro__ for name in [*vars(base).get("__annotations__", {}), *vars(base)]]
    return sorted(public_members(cls), key=order.index)


def fields_told_by_the_class(cls):
    """The fields of a dataclass that the class's own docstring lists, and the members of an enumeration."""
    if issubclass(cls, enum.Enum):
        return set(cls.__members__)
    fields = [field.name for field in dataclasses.fields(cls)] if dataclasses.is_dataclass(cls) else []
    return {name for name in fields if re.search(rf"(?m)^    {name}: ", inspect.getdoc(cls) or "")}


def _reached_from(thing):
    """The classes in the annotations of a function, or of a class and of what it inherits."""
    owners = [thing] if inspect.isfunction(thing) else [base for base in thing.__mro__ if base.__module__.startswith("ulna.")]
    members = [_function(member) for owner in owners if inspect.isclass(owner) for member in vars(owner).values()]
    return [one for owner in [*owners, *filter(None, members)] for one in _annotated(owner)]


def _function(member):
    member = getattr(member, "func", getattr(member, "fget", getattr(member, "__func__", member)))
    return member if inspect.isfunction(member) and not member.__name__.startswith("_") else None


def _annotated(owner):
    """The classes of this library in the annotations of a function or of a class's public attributes."""
    hints = getattr(owner, "__annotations__", {})
    space = {**_type_checking_names(), **vars(sys.modules[owner.__module__])}
    found = []
    for name, hint in hints.items():
        if not name.startswith("_") and (name == "return" or inspect.isclass(owner)):
            found += _classes_in(eval(hint, space) if isinstance(hint, str) else hint)  # noqa: S307 - our own annotations
    return found


def _type_checking_names():
    """The library's classes by name: some modules import what they annotate for the type checker alone."""
    modules = [module for name, module in sys.modules.items() if name.startswith("ulna.")]
    return {name: one for module in modules for name, one in vars(module).items() if inspect.isclass(one)}


def _classes_in(hint):
    if inspect.isclass(hint) and hint.__module__.startswith("ulna."):
        return [hint]
    return [one for part in typing.get_args(hint) for one in _classes_in(part)]


def _rst(path):
    """What autodoc is to show of a class: all that is public, but what the class's own docstring lists."""
    cls = public_classes()[path]
    told = fields_told_by_the_class(cls) if not issubclass(cls, enum.Enum) else set()
    lines = [f".. autoclass:: {path}"]
    members = [name for name in in_order(cls) if name not in told]
    if members:
        lines += [f"   :members: {', '.join(members)}", "   :undoc-members:"]
    return lines


class Classes(SphinxDirective):
    """``{classes} ulna.Box ulna.Sphere``: the reference of these, complete."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self):
        """Let autodoc write it."""
        text = "\n\n".join("\n".join(["```{eval-rst}", *_rst(path), "```"]) for path in self.arguments[0].split())
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def _check(app, env):  # noqa: ARG001 - Sphinx's signature
    documented = set(env.get_domain("py").objects)
    for name in ulna.__all__:
        if f"ulna.{name}" not in documented:
            _log.warning("ulna.%s is public and not in the reference", name)
        if not inspect.getdoc(getattr(ulna, name)):
            _log.warning("ulna.%s is public and has no docstring", name)
    for path, cls in sorted(public_classes().items()):
        for fault in faults_of(path, cls, documented):
            _log.warning("%s", fault)


def faults_of(path, cls, documented):
    """What is missing in the reference of a class, in words."""
    if path not in documented:
        yield f"{path} is reached from the public names and not in the reference"
    for member in public_members(cls):
        value = inspect.getattr_static(cls, member, None)
        if f"{path}.{member}" not in documented and member not in fields_told_by_the_class(cls):
            yield f"{path}.{member} is public and not in the reference"
        if (inspect.isroutine(value) or isinstance(value, property | cached_property)) and not value.__doc__:
            yield f"{path}.{member} is public and has no docstring"


def setup(app):
    """Compare once all pages are read."""
    app.add_directive("classes", Classes)
    app.connect("env-check-consistency", _check)
    return {"parallel_read_safe": True}
