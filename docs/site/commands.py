"""The reference of the command line: what ``ulna COMMAND --help`` says, of every command."""

import re

import typer

from ulna.cli.app import app as command_line

_PLACE = "<!-- commands -->"


def _read(app, docname, source):  # noqa: ARG001 - Sphinx's signature
    """Write what typer knows of each command where the page has a place for it."""
    if _PLACE in source[0]:
        group = typer.main.get_command(command_line)
        source[0] = source[0].replace(_PLACE, "\n\n".join(_sections(group, "ulna")))


def _sections(group, path):
    for name in group.list_commands(None):
        command = group.commands[name]
        if hasattr(command, "commands"):
            yield from _sections(command, f"{path} {name}")
        else:
            yield "\n".join(_lines(command, f"{path} {name}"))


def _lines(command, path):
    yield f"## {path}"
    yield ""
    yield _plain((command.help or "").split("\f")[0])
    yield ""
    for parameter in command.params:
        if parameter.param_type_name == "argument":
            yield f"`{parameter.metavar or parameter.name.upper()}`\n: {_told(parameter)}\n"
        elif not parameter.hidden:
            names = ", ".join(f"`{name}`" for name in [*parameter.opts, *parameter.secondary_opts])
            yield f"{names}\n: {_told(parameter)}\n"
    if command.epilog:
        yield f"{command.epilog}"


def _told(parameter):
    told = _plain(getattr(parameter, "help", None) or "") or "(see above)"
    return f"{told} Required." if parameter.required else told


def _plain(text):
    """On one line, with options as code."""
    return re.sub(r"(?<!\S)(--[\w-]+)", r"`\1`", " ".join(text.split()))


def setup(app):
    """Fill the place in as the page is read."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
