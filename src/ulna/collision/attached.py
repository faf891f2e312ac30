"""Attached objects: shapes that move with a link and are no part of the description."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.collision.allowed import TOUCH_LINKS_HINT
from ulna.description.name_checks import as_link_names, refuse_no_name
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import Description, Inertia, frozen
from ulna.description.shapes import HalfSpace, Solid
from ulna.errors import GeometryError, InputError, UnknownNameError


@dataclass(frozen=True, eq=False)
class Attached:
    """A shape that is attached to a link.

    Attributes:
        name: Its name in reports.
        shape: Its shape.
        T_link_object: Its pose in the frame of the link, shape (4, 4).
        link: The link that carries it. The two are not checked against each other.
        touch_links: Other links, or other attached objects, that it may touch.
        inertia: Its mass, in its own frame; None for a massless object.

    Raises:
        GeometryError: The shape is not a solid that can be attached.
        InputError: The name is not text, the pose is not a rigid motion, or ``touch_links`` is a single name.
    """

    name: str
    shape: Solid
    T_link_object: NDArray[np.float64]
    link: str
    touch_links: frozenset[str] = frozenset()
    inertia: Inertia | None = None

    def __post_init__(self) -> None:
        refuse_no_name(self.name)
        if isinstance(self.shape, HalfSpace) or not isinstance(self.shape, Solid):
            raise GeometryError(f"{self.name!r} is a {type(self.shape).__name__}, which cannot be attached to a link")
        object.__setattr__(self, "T_link_object", frozen(as_one_pose(self.T_link_object, "T_link_object"), (4, 4)))
        object.__setattr__(self, "touch_links", as_link_names(self.touch_links))

    def __reduce__(self):
        return Attached, (self.name, self.shape, self.T_link_object, self.link, self.touch_links, self.inertia)


def inertias_of(description: Description, attached: tuple[Attached, ...] = ()) -> tuple[tuple[str, Inertia], ...]:
    """The inertias that an arm moves: those of its links and of its attached objects.

    Each comes with the name of its link, and is in that link's frame.
    """
    of_links = ((link.name, link.inertia) for link in description.links if link.inertia is not None)
    of_attached = ((one.link, one.inertia.moved(one.T_link_object)) for one in attached if one.inertia is not None)
    return (*of_links, *of_attached)


def attach(attached: tuple[Attached, ...], new: Attached, link_names: tuple[str, ...]) -> tuple[Attached, ...]:
    """Add an attached object, after a check of its names."""
    names = (*link_names, *(one.name for one in attached))
    if new.name in names:
        raise InputError("name", f"the robot already has a link or an attached object {new.name!r}")
    if new.link not in link_names:
        raise UnknownNameError("link", new.link, link_names)
    for name in new.touch_links:
        if name not in names:
            raise UnknownNameError("link or attached object", name, names, TOUCH_LINKS_HINT)
    return (*attached, new)


def detach(attached: tuple[Attached, ...], name: str) -> tuple[Attached, ...]:
    """Remove the attached object of this name."""
    if name not in {one.name for one in attached}:
        raise UnknownNameError("attached object", name, [one.name for one in attached])
    return tuple(one for one in attached if one.name != name)
