"""Caches the functions of q that are bound to a link."""

from collections.abc import Callable, Hashable
from typing import Any, Generic, Protocol, TypeVar

from numpy.typing import ArrayLike

from ulna.kinematics.tree import Tree


class Compiled(Protocol):
    """A function of q, as ``robot.compile_forward`` returns it."""

    @property
    def in_c(self) -> Callable[..., Any] | None:
        """The same in C, if the extension is there: what is called for one q without a detour through Python."""
        ...

    def __call__(self, q: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        """The result for q, shape (..., n_dof)."""
        ...


KeyT = TypeVar("KeyT", bound=Hashable)
FunctionT = TypeVar("FunctionT", bound=Compiled)


class Bound(dict[KeyT, Callable[..., Any]], Generic[KeyT, FunctionT]):
    """The bound functions of one robot, made when first needed.

    It is a dict, because a look-up in a dict is the fastest way from ``robot.forward_kinematics(q)`` to the function. If two
    threads make the same function at once, the first is kept.
    """

    def __init__(self, tree: Tree) -> None:
        super().__init__()
        self._tree = tree
        self._compiled: dict[KeyT, FunctionT] = {}

    def of(self, key: KeyT) -> FunctionT:
        """The function of a key as an object; a key that is not hashable is refused by name."""
        try:
            known = self._compiled.get(key)
        except TypeError:
            return self.make(key)
        return self._compiled.setdefault(key, self.make(key)) if known is None else known

    def make(self, key: KeyT) -> FunctionT:
        """A new function of a key; each subclass implements it.

        Raises:
            NotImplementedError: The subclass does not.
        """
        raise NotImplementedError

    def __reduce__(self):
        return type(self), (self._tree,)

    def __missing__(self, key: KeyT) -> Callable[..., Any]:
        function = self.of(key)
        return self.setdefault(key, function if function.in_c is None else function.in_c)
