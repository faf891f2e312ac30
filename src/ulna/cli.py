"""The command ``ulna``: the subcommands of ``ulna.commands``, in the order of its help.

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
from ulna.answers.bench import BENCH_KEYS
from ulna.answers.collision import CHECKS_KEYS, REPORT_KEYS
from ulna.answers.comparison import COMPARISON_KEYS
from ulna.answers.dh import DH_KEYS
from ulna.answers.inspection import INSPECTION_KEYS
from ulna.answers.kinematics import IK_KEYS, JACOBIAN_KEYS, POSE_KEYS
from ulna.answers.robot import INFO_KEYS
from ulna.answers.warmup import WARMUP_KEYS
from ulna.commands.bench import bench
from ulna.commands.collision import check
from ulna.commands.compare import compare
from ulna.commands.demo import demo
from ulna.commands.dh import dh
from ulna.commands.inspect import inspect
from ulna.commands.kinematics import fk, ik, jacobian
from ulna.commands.record import record
from ulna.commands.robot import info, urdf
from ulna.commands.ros import ros1, ros2
from ulna.commands.view import view
from ulna.commands.warmup import warmup
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
