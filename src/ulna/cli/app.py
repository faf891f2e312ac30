"""``ulna``: builds the command line from one file a command, and from what packages add. Used by the script ``ulna``.

Exit status: 0 done; 1 not solved, a collision, or a check that failed; 2 a wrong argument or file; 130 Ctrl-C; 141 the reader of
the output has closed its pipe. Errors are one line on standard error.
"""

import io
import os
import sys
from typing import Annotated

import typer
from typer.core import TyperGroup

from ulna import __version__
from ulna.cli.bench import BENCH_KEYS, bench
from ulna.cli.check import CHECK_KEYS, check
from ulna.cli.compare import COMPARE_KEYS, compare
from ulna.cli.dh import DH_KEYS, dh
from ulna.cli.fk import FK_KEYS, fk
from ulna.cli.ik import IK_KEYS, ik
from ulna.cli.info import INFO_KEYS, info
from ulna.cli.inspect import INSPECT_KEYS, inspect
from ulna.cli.jacobian import JACOBIAN_KEYS, jacobian
from ulna.cli.plugins import COMMANDS, load_plugins
from ulna.cli.record import record
from ulna.cli.urdf import urdf
from ulna.cli.view import view
from ulna.cli.warmup import WARMUP_KEYS, warmup
from ulna.errors import UlnaError

# Each command with the meaning of its JSON, in the order of the help.
_COMMANDS = (
    (info, INFO_KEYS),
    (fk, FK_KEYS),
    (jacobian, JACOBIAN_KEYS),
    (ik, IK_KEYS),
    (check, CHECK_KEYS),
    (dh, DH_KEYS),
    (compare, COMPARE_KEYS),
    (inspect, INSPECT_KEYS),
    (urdf, None),
    (view, None),
    (record, None),
    (bench, BENCH_KEYS),
    (warmup, WARMUP_KEYS),
)


class _Commands(TyperGroup):
    """The commands. An error of the library is one line, and a closed pipe ends them without a word."""

    def list_commands(self, ctx):
        """The commands in the order of the help: those that packages add come after ``view``, their groups last."""
        own = [command.__name__ for command, _ in _COMMANDS]
        places = {name: k for k, name in enumerate(own)}

        def place(name: str) -> float:
            is_group = isinstance(self.commands[name], TyperGroup)
            return places.get(name, len(own) if is_group else places["view"] + 0.5)

        return sorted(super().list_commands(ctx), key=place)

    def invoke(self, ctx):
        """Run a command."""
        try:
            return super().invoke(ctx)
        except UlnaError as error:
            typer.echo(f"ulna: {' '.join(str(error).split())}", err=True)
            raise typer.Exit(2) from None
        except OSError as error:  # of the output: a file that cannot be read is an UlnaError
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more as it ends
            if isinstance(error, BrokenPipeError):
                raise typer.Exit(141) from None
            typer.echo(f"ulna: {error.strerror or error}", err=True)
            raise typer.Exit(2) from None


app = typer.Typer(
    cls=_Commands,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(value: bool) -> None:  # noqa: FBT001 -- typer calls it so
    if value:
        typer.echo(f"ulna {__version__}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True, help="The version.")]


@app.callback()
def main(*, version: Version = False) -> None:  # noqa: ARG001 -- its callback has done it
    """Robot-arm kinematics and collision checking.

    Every command says more: ulna fk --help.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name that the terminal's encoding does not have is escaped


for command, keys in _COMMANDS:
    app.command(epilog=keys and f"JSON: {keys}")(command)
for commands in load_plugins(COMMANDS):
    app.add_typer(commands)
