"""The command ``ulna``: the subcommands of ``ulna.cli``, in the order of its help.

Exit status: 0 done; 1 the answer is no (not solved, collision, a check that failed); 2 the question is wrong; 130 Ctrl-C; 141
nobody reads the output any more. Errors are one line on standard error.
"""

import io
import os
import sys
from typing import Annotated

import typer
from typer.core import TyperGroup

import ulna
from ulna.cli.bench import BENCH_KEYS, bench
from ulna.cli.check import REPORT_KEYS, check
from ulna.cli.compare import COMPARISON_KEYS, compare
from ulna.cli.dh import DH_KEYS, dh
from ulna.cli.fk import POSE_KEYS, fk
from ulna.cli.ik import IK_KEYS, ik
from ulna.cli.info import INFO_KEYS, info
from ulna.cli.inspect import INSPECTION_KEYS, inspect
from ulna.cli.jacobian import JACOBIAN_KEYS, jacobian
from ulna.cli.record import record
from ulna.cli.urdf import urdf
from ulna.cli.view import view
from ulna.cli.warmup import WARMUP_KEYS, warmup
from ulna.demo.command import CHECKS_KEYS, demo
from ulna.demo.ros.command import ros1, ros2
from ulna.errors import UlnaError

# Each subcommand, with what its JSON means.
_COMMANDS = (
    (info, INFO_KEYS),
    (fk, POSE_KEYS),
    (jacobian, JACOBIAN_KEYS),
    (ik, IK_KEYS),
    (check, REPORT_KEYS),
    (dh, DH_KEYS),
    (compare, COMPARISON_KEYS),
    (inspect, INSPECTION_KEYS),
    (urdf, None),
    (view, None),
    (demo, CHECKS_KEYS),
    (record, None),
    (bench, BENCH_KEYS),
    (warmup, WARMUP_KEYS),
)


class _Commands(TyperGroup):
    """The subcommands, with errors of the library as one line and a closed pipe as the quiet end."""

    def invoke(self, ctx):
        try:
            return super().invoke(ctx)
        except UlnaError as error:
            typer.echo(f"ulna: {' '.join(str(error).split())}", err=True)
            raise typer.Exit(2) from None
        except OSError as error:  # of the output: files that cannot be read are an UlnaError
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


def _version(value: bool) -> None:  # noqa: FBT001 -- typer calls it so
    if value:
        typer.echo(f"ulna {ulna.__version__}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="The version.")]


@app.callback()
def main(*, version: Version = False) -> None:  # noqa: ARG001 -- its callback has done it
    """Robot-arm kinematics and collision checking.

    Every command says more: ulna fk --help.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name that the terminal cannot write is no reason to fail


for command, keys in _COMMANDS:
    app.command(epilog=keys and f"JSON: {keys}")(command)
app.add_typer(ros1, name="ros1")
app.add_typer(ros2, name="ros2")
