"""How fast a motion may be: ``--velocity``, ``--acceleration``, ``--jerk``. Used by ``plan``."""

from typing import Annotated, Any

import numpy as np
import typer

from ulna.cli.depends import Depends
from ulna.cli.numbers import numbers, words
from ulna.cli.options import AnyRobot
from ulna.planning.trajectory import as_limits
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate, coordinates_of

Velocity = Annotated[
    str | None,
    typer.Option(metavar="NUMBERS", help="The greatest [rad/s or m/s] of all joints or of each, below their own limits."),
]
Acceleration = Annotated[str, typer.Option(metavar="NUMBERS", help="The greatest [rad/s^2 or m/s^2] of all joints or of each.")]
Jerk = Annotated[
    str | None,
    typer.Option(metavar="NUMBERS", help="The greatest [rad/s^3 or m/s^3]; the motion then stops at every corner."),
]
_VELOCITY = "1"  # [rad/s or m/s], of joints without a limit


def rates_of(
    robot: AnyRobot, *, velocity: Velocity = None, acceleration: Acceleration = "5", jerk: Jerk = None
) -> dict[str, Any]:
    """The arguments of ``Plan.trajectory``: the greatest velocity, acceleration and jerk of each joint, or of all.

    Raises:
        InputError: They are neither one number above 0 nor n_dof.
    """
    own = robot.velocity_limits
    velocities = as_limits("velocity", _limits("--velocity", velocity or _VELOCITY, robot), robot.n_dof)
    return {
        "velocity": np.where(np.isinf(own), velocities, own) if velocity is None else np.minimum(own, velocities),
        "acceleration": _limits("--acceleration", acceleration, robot),
        "jerk": None if jerk is None else _limits("--jerk", jerk, robot),
    }


Rates = Annotated[dict[str, Any], Depends(rates_of)]


def _limits(option: str, text: str, robot: Robot) -> float | list[float]:
    """The number of an option, or one for each entry of q."""
    if len(words(text)) == 1:
        return numbers(option, text, [Coordinate("of all joints", "")])[0]
    return numbers(option, text, [Coordinate(entry.name, "") for entry in coordinates_of(robot)])
