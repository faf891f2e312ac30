"""Builds the command line ``ulna`` from one file for each command, and from plugins.

Exit status: 0 success; 1 not solved, a collision, or a failed check; 2 a wrong argument or file; 130 Ctrl-C; 141 a closed pipe on
the output side. An error is one line on standard error. With ``--json`` it is an object: the error's class and its message.
"""

import io
import json
import os
import sys
from collections.abc import Iterable
from importlib import import_module
from inspect import cleandoc
from typing import Annotated, Any

import typer
from rich.markup import escape
from typer.core import TyperGroup

from ulna import __version__
from ulna.cli.output import warn
from ulna.cli.quiet_imports import quiet_imports
from ulna.errors import UlnaError

# The commands in the order of the help, by panel. Each is a function in a file of its name; ``<NAME>_KEYS`` describes its JSON.
PANELS = {
    "Look": ("view", "servo", "record"),
    "Compute": ("fk", "jacobian", "ik", "torque", "check", "reach"),
    "Plan and move": ("plan", "follow", "run"),
    "Describe": ("list", "info", "dh", "compare", "inspect", "urdf"),
    "This machine": ("bench", "warmup"),
}
OWN = tuple(name for names in PANELS.values() for name in names)
_PANEL_OF = {name: panel for panel, names in PANELS.items() for name in names}
_LAST_BEFORE_PLUGINS = "servo"
_ARGUMENTS = "ulna.arguments"
_OPTIONS_OF_WORDS = {  # the library's advice to a program, and the matching option of the command line
    "ulna.load(..., srdf=...)": "--srdf FILE",
    "resume=True (--resume)": "--resume",
    "package_dirs": "--package-dir",
    "xacro_args": "--xacro-arg",
}
_UsageError: Any = typer.BadParameter.__base__  # click's error for wrong arguments; typer may bundle its own copy of click


class _Commands(TyperGroup):
    """Group of Ulna's and plugins' commands; imports a command's file when it is called, all files for the help."""

    def get_command(self, ctx, cmd_name):
        """Return the command with a name, or None; names that are not Ulna's own are looked up in the plugins."""
        if cmd_name in OWN:
            self._load([cmd_name])
        elif cmd_name not in self.commands:
            self._load_plugin_commands()
            if cmd_name not in self.commands:
                self._load(OWN)  # a mistyped name: the suggestion considers all names
        return super().get_command(ctx, cmd_name)

    def parse_args(self, ctx, args):
        """Store the arguments: with ``--json`` an error is printed as JSON too."""
        ctx.meta[_ARGUMENTS] = tuple(args)
        return super().parse_args(ctx, args)

    def list_commands(self, ctx):
        """List every name in the order of the help: commands of plugins after ``servo``, groups of plugins last."""
        self._load(OWN)
        self._load_plugin_commands()
        places = {name: k for k, name in enumerate(OWN)}

        def place(name: str) -> float:
            is_group = isinstance(self.commands[name], TyperGroup)
            return places.get(name, len(OWN) if is_group else places[_LAST_BEFORE_PLUGINS] + 0.5)

        return sorted(super().list_commands(ctx), key=place)

    def _load(self, names: Iterable[str]) -> None:
        self.commands.update({name: _import_command(name) for name in names if name not in self.commands})

    def _load_plugin_commands(self) -> None:
        from ulna.cli.plugins import COMMANDS, load_plugins  # noqa: PLC0415 -- most commands need no plugin

        plugins = typer.Typer()
        plugins.callback()(_do_nothing)
        with quiet_imports():
            for commands in load_plugins(COMMANDS):
                plugins.add_typer(commands)
        self.commands.update({name: _with_verbatim_help(each) for name, each in typer.main.get_group(plugins).commands.items()})

    def get_params(self, ctx):
        """Return the options; flags take no value."""
        return _hide_flag_types(super().get_params(ctx))

    def invoke(self, ctx):
        """Run a command, and print an error as one line, or as JSON."""
        as_json = "--json" in ctx.meta[_ARGUMENTS]
        try:
            return super().invoke(ctx)
        except UlnaError as error:
            _print_error(error, str(error), as_json=as_json)
            raise typer.Exit(2) from None
        except _UsageError as error:
            if not as_json:
                raise
            _print_error(error, error.format_message(), as_json=True)
            raise typer.Exit(2) from None
        except OSError as error:  # an error of the output: an unreadable input file is an UlnaError
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes stdout once more at exit
            if isinstance(error, BrokenPipeError):
                raise typer.Exit(141) from None
            _print_error(error, error.strerror or str(error), as_json=as_json)
            raise typer.Exit(2) from None


def _print_error(error: Exception, message: str, *, as_json: bool) -> None:
    for words, option in _OPTIONS_OF_WORDS.items():
        message = message.replace(words, option)
    if as_json:
        typer.echo(json.dumps({"error": type(error).__name__, "message": message}), err=True)
    else:
        warn(message)


def _import_command(name: str):
    """Import one command from its file."""
    with quiet_imports():
        module = import_module(f"ulna.cli.{name}")
    if hasattr(module, "GROUP"):  # a group of several commands
        found = typer.main.get_command(module.GROUP)
    else:
        keys = getattr(module, f"{name.upper()}_KEYS", None)
        alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        alone.command(epilog=keys and f"JSON: {keys}")(getattr(module, name))
        found = typer.main.get_command(alone)
    found.name = name
    vars(found)["rich_help_panel"] = _PANEL_OF[name]  # both a typer command and a group read this attribute
    return _with_verbatim_help(found)


def _with_verbatim_help(found):
    """Make the help print as written: brackets are no markup, and only an empty line begins a paragraph.

    Flags show no type, since they take no value.
    """
    own = found.get_params
    found.get_params = lambda ctx: _hide_flag_types(own(ctx))
    for part in (found, *found.params):
        if getattr(part, "help", None):
            part.help = "\n\n".join(escape(" ".join(each.split())) for each in cleandoc(part.help).split("\n\n"))
    for each in getattr(found, "commands", {}).values():
        _with_verbatim_help(each)
    return found


def _hide_flag_types(parameters):
    """Remove the type of flags, ``--help`` included, from the help."""
    for each in parameters:
        if getattr(each, "is_flag", False):
            each.metavar = ""
    return parameters


def _do_nothing() -> None:
    pass


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(value: bool) -> None:  # noqa: FBT001 -- typer's signature
    if value:
        typer.echo(f"ulna {__version__}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")]


@app.callback()
def main(*, version: Version = False) -> None:  # noqa: ARG001 -- the option's callback prints it
    """Robot-arm kinematics, collision checking and motion planning.

    See the help of each command for details: ulna fk --help.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # characters outside the terminal's encoding are escaped
