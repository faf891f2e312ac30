"""``ulna dh``: the Denavit-Hartenberg table of a chain."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import command
from ulna.cli.options import AnyRobot, Link
from ulna.cli.output import Output, attributes, make_table
from ulna.dh.table import PARALLEL, ROW_PRODUCTS, mimic_words, pose_words, proof_words, row_words

Convention = Annotated[str, typer.Option(metavar="NAME", help="modified (Craig) or standard.")]
ParallelTolerance = Annotated[float, typer.Option(metavar="RAD", help="Axes within this angle count as parallel.")]

DH_KEYS = (
    "robot; base; tip; convention: modified or standard; rows: one for each moving joint, with joint, type, a, d, alpha, "
    "theta_offset, mimic (joint of another row, multiplier, offset, or null); T_base_0 and T_n_tip: 4x4; proof: "
    "max_position_difference, max_rotation_difference, n_configurations; notes."
)
_NUMBERS = ("a", "d", "alpha", "theta_offset")


@command
def dh(robot: AnyRobot, link: Link, *, convention: Convention = "modified", tolerance: ParallelTolerance = PARALLEL) -> Output:
    """Print the Denavit-Hartenberg table from the base to a link, and the proof that it describes the same robot.

    Fixed joints are merged into the poses of frame 0 and of the tip.
    """
    table = robot.dh(convention=convention, link=link, tolerance=tolerance)
    columns = zip(table.joint_names, table.joint_types, table.rows, table.mimics, strict=True)
    data = {
        "robot": table.name,
        **attributes(table, "base", "tip", "convention"),
        "rows": [
            {"joint": name, "type": kind, **dict(zip(_NUMBERS, row, strict=True)), "mimic": mimic and asdict(mimic)}
            for name, kind, row, mimic in columns
        ],
        **attributes(table, "T_base_0", "T_n_tip"),
        "proof": attributes(table, "max_position_difference", "max_rotation_difference", "n_configurations"),
        "notes": table.notes,
    }
    return Output(data, dh_table)


def dh_table(data) -> Iterator[RenderableType]:
    """Show the rows with q in its place, the fixed poses before and after them, notes, and the proof."""
    heading = f"{data['robot']}: {data['convention']} DH table from {data['base']} to {data['tip']}"
    yield Text.assemble((heading, "bold"), f"\na row is {ROW_PRODUCTS[data['convention']]}")
    table = make_table(["", "joint"], ["a [m]", "d [m]", "alpha [rad]", "theta [rad]"], [])
    names = [row["joint"] for row in data["rows"]]
    for k, row in enumerate(data["rows"], start=1):
        table.add_row(str(k), row["joint"], *row_words(k, row["type"], [row[key] for key in _NUMBERS]))
    yield table
    for k, row in enumerate(data["rows"], start=1):
        if row["mimic"] is not None:
            yield mimic_words(k, names.index(row["mimic"]["joint"]) + 1, row["mimic"]["multiplier"], row["mimic"]["offset"])
    yield f"frame 0 in {data['base']}: {pose_words(np.array(data['T_base_0']))}"
    yield f"{data['tip']} in frame {len(data['rows'])}: {pose_words(np.array(data['T_n_tip']))}"
    yield from data["notes"]
    yield proof_words(*data["proof"].values())
