"""What a collision check, or the assignment's own checks, found."""

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from ulna.answers.entries import Q_KEYS, data_of_q
from ulna.answers.plain import Data
from ulna.collision.report import Report
from ulna.robot import Robot

REPORT_KEYS = (
    f"{Q_KEYS}; in_collision; signed_distance: the least, null if there is nothing to measure to; touching: shapes of the robot; "
    "pairs: name_a of the robot, link, name_b and link_b (null: of the world), signed_distance (negative: overlap), witness_a and "
    "witness_b: the nearest points, normal from a to b."
)
CHECKS_KEYS = "passed; checks: name, figure, bound, passed."


def report_data(robot: Robot, q: NDArray[np.float64], report: Report, distance: float) -> Data:
    """What a collision check found, and the least distance; see ``REPORT_KEYS``."""
    pairs = [{field.name: getattr(pair, field.name) for field in fields(pair)} for pair in report.pairs]
    verdict = {"in_collision": report.in_collision, "signed_distance": distance, "touching": report.touching}
    return {**data_of_q(robot, q), **verdict, "pairs": pairs}
