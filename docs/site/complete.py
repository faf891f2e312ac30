"""Refuses a reference that leaves a public name out (``public.py`` says what is public), or shows one without a docstring."""

import enum
import inspect
from functools import cached_property

from docstrings import fields_without_words, type_words
from public import fields_told_by_the_class, in_order, public_classes, public_members
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

import ulna

_log = logging.getLogger(__name__)


def _rst(path):
    """What autodoc is to show of a class: all that is public, but what the class's own docstring lists.

    Fields without a docstring come first, with their types: their names and the class say what they are.
    """
    cls = public_classes()[path]
    told = set() if issubclass(cls, enum.Enum) else fields_told_by_the_class(cls)
    members = [name for name in in_order(cls) if name not in told]
    silent = [name for name in members if name in fields_without_words(cls)]
    listed = [name for name in members if name not in silent]
    yield f".. autoclass:: {path}"
    if listed:
        yield from (f"   :members: {', '.join(listed)}", "   :undoc-members:")
    for name in silent:
        yield from ("", f"   .. autoattribute:: {name}", f"      :annotation: : {type_words(cls, name)}")


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
