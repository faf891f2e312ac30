"""The Denavit-Hartenberg table of a chain."""

from dataclasses import asdict

from ulna.answers.plain import Data
from ulna.model.dh_table import DHTable

DH_KEYS = (
    "robot; base; tip; convention: modified or standard; rows: one for each moving joint, with joint, type, a, d, alpha, "
    "theta_offset, mimic (joint of another row, multiplier, offset, or null); T_base_0 and T_n_tip: 4x4; proof: "
    "max_position_difference, max_rotation_difference, n_configurations; notes."
)


def dh_data(table: DHTable) -> Data:
    """The table; see ``DH_KEYS``."""
    keys = ("a", "d", "alpha", "theta_offset")
    return {
        "robot": table.name,
        "base": table.base,
        "tip": table.tip,
        "convention": table.convention,
        "rows": [
            {"joint": name, "type": kind, **dict(zip(keys, row, strict=True)), "mimic": None if mimic is None else asdict(mimic)}
            for name, kind, row, mimic in zip(
                table.joint_names, table.joint_types, table.rows.tolist(), table.mimics, strict=True
            )
        ],
        "T_base_0": table.T_base_0,
        "T_n_tip": table.T_n_tip,
        "proof": {
            "max_position_difference": table.max_position_difference,
            "max_rotation_difference": table.max_rotation_difference,
            "n_configurations": table.n_configurations,
        },
        "notes": table.notes,
    }
