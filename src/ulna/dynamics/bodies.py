"""Merges the inertias of links into one body per moving joint."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.description.robot_description import Description, Inertia, Link, frozen
from ulna.errors import InertiaError, InputError, UnknownNameError, listed
from ulna.kernels.dynamics.dynamics_records import Mechanism
from ulna.kernels.layout import BASE, INERTIA_WIDTH
from ulna.kinematics.tree import Tree

_TRIANGLE = np.triu_indices(3)


def mechanism_of(tree: Tree, links: Iterable[Link], inertias: Iterable[tuple[str, Inertia]]) -> Mechanism:
    """A robot's joints and the table of the inertias that they carry.

    inertias: the inertias of links and attached objects, each with the name of the link in whose frame it is given.

    Raises:
        InertiaError: A moving link has a shape but no inertia; or no moving link has an inertia.
    """
    moving = [link for link in links if tree.link_row[link.name] != BASE]
    missing = [link.name for link in moving if link.inertia is None and (link.visuals or link.collisions)]
    if missing:
        raise InertiaError(f"no torque can be computed: {_describe_missing(missing)}; {_REMEDY}", missing)
    if all(link.inertia is None for link in moving):
        names = [link.name for link in moving]
        raise InertiaError(f"no torque can be computed: no link of {tree.name!r} that moves has an inertia; {_REMEDY}", names)
    table = np.zeros((len(tree.joints), INERTIA_WIDTH))
    for link, inertia in inertias:
        row = tree.link_row[link]
        if row != BASE:
            table[row] += inertia_row(inertia, tree.link_offset[link])
    return Mechanism(tree.joints, frozen(table, table.shape))


def point_mass(tree: Tree, link: str, center: NDArray[np.float64]) -> Mechanism:
    """A massless copy of a robot with one kilogram at a point of a link, shape (3,)."""
    table = np.zeros((len(tree.joints), INERTIA_WIDTH))
    if tree.link_row[link] != BASE:
        table[tree.link_row[link]] = inertia_row(Inertia(1.0, center, np.zeros((3, 3))), tree.link_offset[link])
    return Mechanism(tree.joints, frozen(table, table.shape))


def replace_inertias(description: Description, inertias: Mapping[str, Inertia | None]) -> Description:
    """A copy of a description with other inertias of some links."""
    names = {link.name for link in description.links}
    for name, inertia in inertias.items():
        if name not in names:
            raise UnknownNameError("link", name, names)
        if not isinstance(inertia, Inertia | None):
            raise InputError("inertias", f"{type(inertia).__name__} for {name!r}; an ulna.Inertia or None is expected")
    links = (replace(link, inertia=inertias.get(link.name, link.inertia)) for link in description.links)
    return replace(description, links=tuple(links), text="")


def inertia_row(inertia: Inertia, T_row_link: NDArray[np.float64]) -> NDArray[np.float64]:
    """The row of the table of inertias for a link, shape (10,), from the link's pose in its joint's frame.

    The tensor is shifted from the center of mass c to the origin by m (|c|^2 I - c c') (parallel axis theorem).
    """
    R, center = T_row_link[:3, :3], T_row_link[:3, :3] @ inertia.center + T_row_link[:3, 3]
    tensor = R @ inertia.tensor @ R.T + inertia.mass * (center @ center * np.eye(3) - np.outer(center, center))
    return np.array([inertia.mass, *(inertia.mass * center), *tensor[_TRIANGLE]])


_REMEDY = "robot.with_inertias({'link': ulna.Inertia(mass, center, tensor)}) gives them"


def _describe_missing(links: list[str]) -> str:
    return f"{listed(links)} {'has' if len(links) == 1 else 'have'} a shape and no inertia"
