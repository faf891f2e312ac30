"""How two robots differ."""

from dataclasses import asdict

from ulna.answers.plain import Data
from ulna.comparison.result import Comparison

COMPARISON_KEYS = (
    "same; name_a; name_b; matched_by: name or order; differences: kind, where, a, b (in words); max_position_difference; "
    "max_rotation_difference; poses: link_a, link_b, and the largest position and rotation between them; frame_a and frame_b: "
    "the links in which poses are taken; n_configurations; tolerances."
)


def comparison_data(comparison: Comparison) -> Data:
    """The differences; see ``COMPARISON_KEYS``."""
    return {
        "same": comparison.same,
        "max_position_difference": comparison.max_position_difference,
        "max_rotation_difference": comparison.max_rotation_difference,
        **asdict(comparison),
    }
