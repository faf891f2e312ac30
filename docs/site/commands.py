"""Writes the reference of the command line from what typer knows of each command."""

import re

import typer

from ulna.cli.app import app as command_line

_PLACE = "<!-- commands -->"
_TYPES = {"str": "text", "int": "integer", "int range": "integer", "float": "number", "float range": "number"}  # by typer


def _read(app, docname, source):  # noqa: ARG001 - Sphinx's signature
    """Put the reference where the page has a place for it."""
    if _PLACE in source[0]:
        source[0] = source[0].replace(_PLACE, reference())


def reference():
    """A section for each command, as Markdown: usage, arguments, options, keys of the JSON."""
    group = typer.main.get_command(command_line)
    return "\n\n".join(_sections(group, group.context_class(group, info_name="ulna")))


def _sections(group, context):
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        own = command.context_class(command, info_name=name, parent=context)
        if hasattr(command, "commands"):
            yield from _sections(command, own)
        else:
            yield "\n".join(_lines(command, own))


def _lines(command, context):
    yield f"## {context.command_path}\n"
    yield _plain((command.help or "").split("\f")[0])
    yield f"\n```text\n{command.get_usage(context).removeprefix('Usage: ')}\n```\n"
    for parameter in command.params:
        if not getattr(parameter, "hidden", False):
            yield _parameter(*parameter.get_help_record(context))
    if command.epilog:
        yield f"{command.epilog}"


def _parameter(names, text):
    """An entry of a definition list, from typer's line about a parameter: its names and type; help, default and range."""
    written, _, kind = names.partition(" <")
    kind = kind.rstrip(">").removeprefix("list[").rstrip("]")
    names = " / ".join(f"`{name}`" for name in written.split(" / "))
    return f"{names}{f' ({_TYPES.get(kind, kind)})' if kind else ''}\n: {_plain(text)}\n"


def _plain(text):
    """On one line, with options as code and without the backslashes that keep brackets from being markup of rich."""
    return re.sub(r"(?<!\S)(--[\w-]+)", r"`\1`", " ".join(text.replace(r"\[", "[").split()))


def setup(app):
    """Fill the place in as the page is read."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
