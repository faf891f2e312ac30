"""``ulna bench``: how fast it is on this machine."""

from typing import Annotated

import typer

from ulna.bench.arms import NAMES
from ulna.bench.report import SUBJECTS, measure
from ulna.commands.options import Json
from ulna.tables.bench import bench_view
from ulna.tables.writing import show


def bench(
    subjects: Annotated[
        list[str] | None, typer.Argument(metavar="SUBJECT...", help=f"{', '.join(SUBJECTS)}; all of them unless given.")
    ] = None,
    *,
    robot: Annotated[list[str] | None, typer.Option(metavar="ROBOT", help=f"{', '.join(NAMES)}, or a file; repeatable.")] = None,
    n: Annotated[int, typer.Option("--n", min=1, help="Targets of each protocol of inverse kinematics.")] = 1000,
    as_json: Json = False,
) -> None:
    """Time Ulna on this machine: medians and quartiles of one call and of a batch, and the rates at which targets are solved.

    As in: ulna bench ik --robot ur5 --robot jaco2 --n 10000. The protocols are told in docs/performance.md.
    """
    data = measure(subjects or (), robot or ("panda",), n)
    show(data, None if as_json else bench_view)
