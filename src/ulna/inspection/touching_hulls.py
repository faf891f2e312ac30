"""Checks whether the convex hulls of a robot's meshes touch where the meshes may not: at home, and at random configurations."""

from collections.abc import Iterator

from ulna.description.meshes.hulls import n_collision_meshes
from ulna.description.shapes import Mesh
from ulna.errors import UlnaError, listed
from ulna.inspection.result import Finding, Severity
from ulna.robot import Robot

_OFTEN, _MOSTLY = 0.1, 0.5  # shares of the random configurations: what is said, and what makes it a warning
_WAYS = (
    "If the meshes do not touch: robot.with_allowed_collisions(at=q) allows what touches at a q or a state of the SRDF that is "
    "known to be free, robot.with_allowed_collisions([(link, link)]) single pairs, and meshes='decompose' follows hollows"
)


def hull_findings(robot: Robot) -> Iterator[Finding]:
    """Which checked pairs of links, one of them with a mesh, touch as hulls. What cannot be read has its own finding."""
    if not n_collision_meshes(robot.description) or not robot.n_dof:
        return
    meshed = {link.name for link in robot.description.links if any(isinstance(body.shape, Mesh) for body in link.collisions)}
    try:
        hulls = robot.with_convex_hulls()
        pairs = sorted(hulls.allowed_collisions.touching(_OFTEN), key=lambda pair: (-pair.touched, pair.link_a, pair.link_b))
        home = hulls.check_collision(hulls.home).pairs
    except UlnaError:
        return
    often = [pair for pair in pairs if not meshed.isdisjoint(pair.links)]
    if often:
        words = [f"{pair.link_a} and {pair.link_b} at {pair.touched} ({pair.touched / pair.samples:.0%})" for pair in often]
        severity = Severity.WARNING if often[0].touched >= _MOSTLY * often[0].samples else Severity.NOTE
        yield Finding(severity, "document", f"hulls touch, of {often[0].samples} random q: {listed(words)}. {_WAYS}")
    touching = {frozenset((pair.link_a, str(pair.link_b))) for pair in home if pair.signed_distance <= 0.0}
    at_home = [" and ".join(sorted(links)) for links in touching if not meshed.isdisjoint(links)]
    if at_home:
        message = (
            f"hulls touch at robot.home: {listed(sorted(at_home))}. If it is free: robot.with_allowed_collisions(at=robot.home)"
        )
        yield Finding(Severity.NOTE, "document", message)
