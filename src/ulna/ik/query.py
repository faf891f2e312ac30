"""Prepares what is the same for every target: one link of a robot, and options."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.errors import InputError
from ulna.ik.lengths import arm_length, far_square, unit_of_length
from ulna.ik.options import Options
from ulna.ik.reach import Reach, reach_of
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.sample import usual_range
from ulna.kinematics.tree import Tree, lengthened

Array = NDArray[np.float64]
STEPS, SEEDED_STEPS = 20, 60  # from one start before the next; from the caller's own


@dataclass(frozen=True, eq=False)
class Query:
    """One link of a robot, and the options of a search: whatever does not depend on the target.

    Attributes:
        tree: The robot.
        home: Where a search without a seed starts [rad or m], shape (n_dof,).
        checker: The robot's collision checker, used if a world is given.
        link: The link that is brought to the target.
        options: What the caller chose.

    Raises:
        InputError: The robot has no joint.
        UnknownNameError: There is no such link.
    """

    tree: Tree
    home: Array
    checker: Checker
    link: str
    options: Options

    def __post_init__(self) -> None:
        refuse_immovable(self.tree)
        self.tree.chain(self.link)

    @cached_property
    def task_axes(self) -> Array | None:
        """The axes of the task in the link, shape (3, 3); None where they are the link's own."""
        return self.options.task.turn

    @cached_property
    def T_link_task(self) -> Array:  # noqa: N802 - a pose
        """The pose of the task's frame in the link, shape (4, 4)."""
        return self.options.task.frame

    @cached_property
    def chain(self) -> Array:
        """The chain to the frame of the task: the link, turned by ``task_axes``."""
        chain = self.tree.chain(self.link)
        if self.task_axes is None:
            return chain
        return lengthened(chain, self.T_link_task)

    @cached_property
    def limits(self) -> Array:
        """Lower and upper limits, and the usual range, from which starts are taken: shape (1, 4, n_dof)."""
        return np.array([[*self.tree.bounds, *usual_range(*self.tree.bounds)]])

    @cached_property
    def settings(self) -> Array:
        """The settings of the kernels (``kernels.ik.search_layout``), shape (N_SETTINGS,)."""
        settings, options = np.zeros(layout.N_SETTINGS), self.options
        settings[layout.POSITION_TOLERANCE] = options.position_tolerance
        settings[layout.ROTATION_TOLERANCE] = options.rotation_tolerance
        settings[layout.STEPS], settings[layout.TASK] = STEPS, options.task.kind
        settings[layout.FAR] = far_square(self.tree, self.link)
        settings[layout.SLACK : layout.SLACK + 6] = options.task.slack
        return settings

    @cached_property
    def unit(self) -> float:
        """The unit of length of the search [m]: 1 for arms of the usual size."""
        return unit_of_length(arm_length(self.tree, self.link))

    @cached_property
    def reach(self) -> Reach | None:
        """How far the link can reach; None where that has no bound."""
        return reach_of(self.tree.chain(self.link), self.tree.lower, self.tree.upper)


def refuse_immovable(tree: Tree) -> None:
    """Refuse a robot without joints.

    Raises:
        InputError: The robot has no moving joint.
    """
    if not tree.n_dof:
        raise InputError("T", "the robot has no moving joints, so nothing can be solved for")
