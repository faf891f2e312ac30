"""``ulna dh`` for people."""

from collections.abc import Iterator

import numpy as np
from rich.console import RenderableType
from rich.text import Text

from ulna.model.dh_table import ROW_PRODUCTS, mimic_words, pose_words, proof_words, row_words
from ulna.tables.writing import make_table


def dh_view(data) -> Iterator[RenderableType]:
    """The rows, with q where it enters, and what stands before and behind them."""
    heading = f"{data['robot']}: {data['convention']} DH table from {data['base']} to {data['tip']}"
    yield Text.assemble((heading, "bold"), f"\na row is {ROW_PRODUCTS[data['convention']]}")
    table = make_table(["", "joint"], ["a [m]", "d [m]", "alpha [rad]", "theta [rad]"], [])
    names = [row["joint"] for row in data["rows"]]
    for k, row in enumerate(data["rows"], start=1):
        numbers = [row[key] for key in ("a", "d", "alpha", "theta_offset")]
        table.add_row(str(k), row["joint"], *row_words(k, row["type"], numbers))
    yield table
    for k, row in enumerate(data["rows"], start=1):
        if row["mimic"] is not None:
            yield mimic_words(k, names.index(row["mimic"]["joint"]) + 1, row["mimic"]["multiplier"], row["mimic"]["offset"])
    yield f"frame 0 in {data['base']}: {pose_words(np.array(data['T_base_0']))}"
    yield f"{data['tip']} in frame {len(data['rows'])}: {pose_words(np.array(data['T_n_tip']))}"
    yield from data["notes"]
    yield proof_words(*data["proof"].values())
