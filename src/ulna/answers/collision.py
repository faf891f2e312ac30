"""What a collision check, or the assignment's own checks, found."""

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from ulna.answers.entries import Q_KEYS, data_of_q
from ulna.answers.plain import Data
from ulna.collision.report import Report
from ulna.robot import Robot

REPORT_KEYS = (
    f"{Q_KEYS}; in_collision; touching: shapes of the robot; pairs: name_a of the robot, name_b of the world, link, "
    "signed_distance (negative: overlap), normal from a to b."
)
CHECKS_KEYS = "passed; checks: name, figure, bound, passed."


def report_data(robot: Robot, q: NDArray[np.float64], report: Report) -> Data:
    """What a collision check found; see ``REPORT_KEYS``."""
    pairs = [{field.name: getattr(pair, field.name) for field in fields(pair)} for pair in report.pairs]
    return {**data_of_q(robot, q), "in_collision": report.in_collision, "touching": report.touching, "pairs": pairs}
