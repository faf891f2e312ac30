"""Finds what a robot touches, and the nearest pair of it and the world. Used by ``session`` and the page."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.errors import GeometryError
from ulna.robot import Robot

_ROUNDING = 1e-5  # [m] by which the distance of one pair may differ when it is measured again


@dataclass(frozen=True, eq=False)
class Clearance:
    """What was found at one configuration.

    Attributes:
        report: What touches; None where the robot's shapes cannot be checked, or are not checked yet.
        nearest: The nearest, or deepest, pair of the robot and the world; None if the world is empty.
        refusal: Why the shapes cannot be checked; empty if they are not checked yet.
    """

    report: Report | None
    nearest: Pair | None = None
    refusal: str = ""

    @property
    def verdict(self) -> str:
        """``free``, ``collision``, ``not checked`` or ``checking ...``."""
        if self.report is None:
            return "not checked" if self.refusal else "checking ..."
        return "collision" if self.report.in_collision else "free"

    @property
    def distance(self) -> str:
        """The distance of the nearest pair in millimetres; empty if there is none."""
        return "" if self.nearest is None else f"{1e3 * self.nearest.signed_distance:.1f} mm"

    def __str__(self) -> str:
        if self.report is None:
            return self.verdict
        hits = [f"{pair.name_a} and {pair.name_b}" for pair in self.report.pairs if pair.signed_distance <= 0.0]
        more = f" and {len(hits) - 3} more" if len(hits) > 3 else ""
        return f"collision: {', '.join(hits[:3])}{more}" if hits else "free"


def clearance(robot: Robot, q: ArrayLike, world: World, *, itself: bool = True) -> Clearance:
    """What touches at q, shape (n_dof,), and the nearest pair; ``itself`` checks the robot's links against each other too."""
    try:
        report = robot.check_collision(q, world, itself)
        distance = robot.signed_distance(q, world, self_collision=False)
    except GeometryError as error:
        return Clearance(None, refusal=str(error))
    near = (
        robot.check_collision(q, world, self_collision=False, max_distance=max(distance, 0.0) + _ROUNDING).pairs
        if world.names
        else ()
    )
    return Clearance(report, near[0] if near else None)
