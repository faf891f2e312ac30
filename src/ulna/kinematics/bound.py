"""Caches the functions of q that are bound to a link. Used by ``kinematics.forward`` and ``kinematics.jacobian``."""

from collections.abc import Hashable
from typing import Generic, TypeVar

from ulna.kinematics.tree import Tree

KeyT = TypeVar("KeyT", bound=Hashable)
FunctionT = TypeVar("FunctionT")


class Bound(dict[KeyT, FunctionT], Generic[KeyT, FunctionT]):
    """The bound functions of one robot, made when first needed.

    It is a dict, because a look-up in a dict is the fastest way from ``robot.forward_kinematics(q)`` to the function. If two
    threads make the same function at once, the first is kept.
    """

    def __init__(self, tree: Tree) -> None:
        super().__init__()
        self._tree = tree

    def of(self, key: KeyT) -> FunctionT:
        """The function of a key; a key that is not hashable is refused by name."""
        try:
            return self[key]
        except TypeError:
            return self.make(key)

    def make(self, key: KeyT) -> FunctionT:
        """A new function of a key; each subclass implements it.

        Raises:
            NotImplementedError: The subclass does not.
        """
        raise NotImplementedError

    def __missing__(self, key: KeyT) -> FunctionT:
        return self.setdefault(key, self.make(key))
