"""What is public, and so must stand in the reference.

That is what stands in ``ulna.__all__`` and ``ulna.arms.__all__``, every class that a user reaches from there through an
annotation (what a method returns, what an attribute holds), and every attribute and method of these that has no underscore in
front.
"""

import enum
import importlib
import inspect
import pkgutil
import re
import sys
import typing
from functools import cache

import ulna
import ulna.arms
from ulna.robot.other_names import OtherName

_NAMED_IN_ANNOTATIONS = (
    "ulna.description",
    "ulna.kinematics",
    "ulna.collision",
    "ulna.ik",
    "ulna.gpu",
    "ulna.robot",
    "ulna.viewer",
    "ulna.arms",
)


def public_classes():
    """The public classes by the name under which the reference has them."""
    waiting = [getattr(ulna, name) for name in ulna.__all__]
    waiting += [thing for name in ulna.arms.__all__ if inspect.isclass(thing := getattr(ulna.arms, name))]
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
    return sorted(name for name in names if not isinstance(vars(cls).get(name), OtherName))


def in_order(cls):
    """The same, constructors and fields first, in the order of the source."""
    order = [name for base in cls.__mro__ for name in [*vars(base).get("__annotations__", {}), *vars(base)]]
    return sorted(public_members(cls), key=order.index)


def fields_told_by_the_class(cls):
    """The members that the class's own docstring lists, and those of an enumeration."""
    if issubclass(cls, enum.Enum):
        return set(cls.__members__)
    listed = re.findall(r"(?m)^    (\w+): ", inspect.getdoc(cls) or "")
    return set(listed) & set(public_members(cls))


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


@cache
def _type_checking_names():
    """The library's classes by name: some modules import what they annotate for the type checker alone."""
    layers = [importlib.import_module(layer) for layer in _NAMED_IN_ANNOTATIONS]
    names = [found.name for layer in layers for found in pkgutil.iter_modules(layer.__path__, f"{layer.__name__}.")]
    modules = [importlib.import_module(name) for name in names]
    return {name: one for module in modules for name, one in vars(module).items() if inspect.isclass(one)}


def _classes_in(hint):
    if inspect.isclass(hint) and hint.__module__.startswith("ulna."):
        return [hint]
    return [one for part in typing.get_args(hint) for one in _classes_in(part)]
