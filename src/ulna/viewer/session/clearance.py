"""Finds the contacts of a robot and its nearest obstacle, and names its shapes by their links."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from numpy.typing import ArrayLike

from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.description.shapes import Mesh, UnknownShape
from ulna.errors import GeometryError
from ulna.robot import Robot


class ShapeNames:
    """The names under which the page shows collision shapes: ``link``, or ``link (shape)`` if a link has several.

    A description numbers its shapes ("box 2"), and so does the page with its obstacles. The link's name distinguishes them.

    Attributes:
        reserved: Names that no obstacle can have: those of links and shapes.
    """

    def __init__(self, robot: Robot) -> None:
        links = [link.name for link in robot.description.links for _ in link.collisions]
        each = Counter(links)
        names = robot.collision_names[: len(links)] if links and not _has_meshes(robot) else ()
        self._shown = {name: link if each[link] == 1 else f"{link} ({name})" for name, link in zip(names, links, strict=False)}
        held = (attached.name for attached in robot.attached)
        self.reserved = frozenset({*robot.link_names, *names, *self._shown.values(), *held})

    def shape_name(self, name: str) -> str:
        """The shown name of a shape of the robot; an attached object keeps its own."""
        return self._shown.get(name, name)

    def pair_names(self, pair: Pair) -> tuple[str, str]:
        """The shown names of both shapes of a pair.

        An obstacle with the name of a part of the robot is shown as "obstacle NAME".
        """
        if pair.link_b is not None:
            return self.shape_name(pair.name_a), self.shape_name(pair.name_b)
        return self.shape_name(pair.name_a), f"obstacle {pair.name_b}" if pair.name_b in self.reserved else pair.name_b

    def list_pairs(self, pairs: Iterable[Pair], most: int = 3) -> str:
        """Pairs in words, such as "panda_link7 and table", at most ``most`` of them."""
        words = [" and ".join(self.pair_names(pair)) for pair in pairs]
        more = f" and {len(words) - most} more" if len(words) > most else ""
        return f"{', '.join(words[:most])}{more}"


def _has_meshes(robot: Robot) -> bool:
    """Whether a robot has collision meshes or unknown shapes, which cannot be checked or named in a report."""
    return any(isinstance(body.shape, Mesh | UnknownShape) for link in robot.description.links for body in link.collisions)


_ROUNDING = 1e-5  # [m] two computations of the distance of one pair may differ by this much


@dataclass(frozen=True, eq=False)
class Clearance:
    """The result of a collision check at one configuration.

    Attributes:
        report: The pairs in contact; None if the robot's shapes cannot be checked, or are not checked yet.
        nearest: The nearest, or deepest, pair of a shape of the robot and an obstacle; None if the world is empty.
        refusal: Why the shapes cannot be checked; empty if they can.
        touching: The pairs in contact, in words; empty if there is none.
        nearest_text: The nearest pair in words; empty if there is none.
    """

    report: Report | None
    nearest: Pair | None = None
    refusal: str = ""
    touching: str = ""
    nearest_text: str = ""

    @property
    def state(self) -> str:
        """``free``, ``collision``, ``not checked`` or ``checking ...``."""
        if self.report is None:
            return "not checked" if self.refusal else "checking ..."
        return "collision" if self.report.in_collision else "free"

    @property
    def distance(self) -> str:
        """The distance of the nearest pair in millimeters; empty if there is none."""
        return "" if self.nearest is None else f"{1e3 * self.nearest.signed_distance:.1f} mm"

    def __str__(self) -> str:
        return f"{self.state}: {self.touching}" if self.touching else self.state


def clearance(robot: Robot, q: ArrayLike, world: World, *, itself: bool = True, names: ShapeNames | None = None) -> Clearance:
    """Find the pairs in contact at q, and the nearest pair of the robot and the world.

    Args:
        robot: The robot.
        q: Joint positions [rad or m], shape (n_dof,).
        world: The obstacles.
        itself: Whether to check the robot's links against each other too.
        names: The shown names of the robot's shapes; made from the robot unless given.
    """
    try:
        report = robot.check_collision(q, world, self_collision=itself)
        distance = robot.signed_distance(q, world, self_collision=False)
    except GeometryError as error:
        return Clearance(None, refusal=str(error))
    near = (
        robot.check_collision(q, world, self_collision=False, max_distance=max(distance, 0.0) + _ROUNDING).pairs
        if world.names
        else ()
    )
    names = names or ShapeNames(robot)
    touching = names.list_pairs(pair for pair in report.pairs if pair.signed_distance <= 0.0)
    return Clearance(report, near[0] if near else None, touching=touching, nearest_text=names.list_pairs(near[:1]))
