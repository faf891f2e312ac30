"""Names the robot's collision shapes by their links, as the page shows them: "panda_link3 (box 2)"."""

from collections import Counter
from collections.abc import Iterable

from ulna.collision.report import Pair
from ulna.description.shapes import Mesh
from ulna.robot import Robot


class ShapeNames:
    """The shown name of each collision shape: the link's; with several shapes on a link, that of the shape behind it.

    A description numbers its shapes ("box 2"), and the page numbers its obstacles: these names could be confused.

    Attributes:
        taken: Names that no obstacle can have: those of links and shapes.
    """

    def __init__(self, robot: Robot) -> None:
        links = [link.name for link in robot.description.links for _ in link.collisions]
        each = Counter(links)
        names = robot.collision_names[: len(links)] if links and not _has_meshes(robot) else ()
        self._shown = {name: link if each[link] == 1 else f"{link} ({name})" for name, link in zip(names, links, strict=False)}
        held = (attached.name for attached in robot.attached)
        self.taken = frozenset({*robot.link_names, *names, *self._shown.values(), *held})

    def of_shape(self, name: str) -> str:
        """The shown name of a shape of the robot; an attached object keeps its own."""
        return self._shown.get(name, name)

    def of_pair(self, pair: Pair) -> tuple[str, str]:
        """The shown names of both shapes of a pair. An obstacle with the name of a part of the robot gets the word "obstacle"."""
        if pair.link_b is not None:
            return self.of_shape(pair.name_a), self.of_shape(pair.name_b)
        return self.of_shape(pair.name_a), f"obstacle {pair.name_b}" if pair.name_b in self.taken else pair.name_b

    def listed(self, pairs: Iterable[Pair], most: int = 3) -> str:
        """Pairs in words, such as "panda_link7 and table", at most ``most`` of them."""
        words = [" and ".join(self.of_pair(pair)) for pair in pairs]
        more = f" and {len(words) - most} more" if len(words) > most else ""
        return f"{', '.join(words[:most])}{more}"


def _has_meshes(robot: Robot) -> bool:
    """Whether it has collision meshes: then its shapes cannot be checked, and no report names them."""
    return any(isinstance(body.shape, Mesh) for link in robot.description.links for body in link.collisions)
