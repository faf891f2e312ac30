"""Computes the poses of links, with NumPy arrays in and out."""

from collections.abc import Callable
from typing import Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.engine.bound import IN_C, Bound, machine_code
from ulna.engine.entries import ready
from ulna.engine.threads import MIN_POSES, in_parts
from ulna.errors import refuse_unknown
from ulna.kinematics.entries import forward
from ulna.kinematics.positions import FLOAT64, NO_Q, as_out, as_positions, flat, for_kernel, refuse_out_of_range
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_SHAPE = (4, 4)


class FunctionOfLink(Bound):
    """A function of q for one link, for a control loop.

    It validates its arguments like the method of ``Robot``, in less time. It can be pickled, and called from many threads at once
    if each has its own ``out``.
    """

    __slots__ = ("_batch", "_leading", "_link", "_one", "_shape", "_tree")

    def __init__(
        self, tree: Tree, link: str, one: Callable[..., bool], batch: Callable[..., bool], frame: tuple[int, ...], shape: tuple
    ) -> None:
        """Take an entry for one q and an entry for a batch.

        Before q, both take the chain and ``frame``. shape: The shape of one result.
        """
        self._tree, self._link, self._shape = tree, link, shape
        self._one, self._batch = ready(one), batch
        chain = tree.chain(link).copy()  # writable: to pass a read-only array takes 30 ns longer
        self._leading = chain, *frame, tree.n_dof or NO_Q
        code = machine_code(self._one, self._leading) if tree.n_dof else None
        super().__init__(code, "pose", self._leading, tree.n_dof, shape, self._validated)

    if not IN_C:

        def __call__(self, q: ArrayLike, out: Array | None = None, **unknown: Never) -> Array:
            """The result at q.

            Args:
                q: Joint positions [rad or m], shape (..., n_dof).
                out: Array for the result, if given: a float64 array of the result's shape.
                **unknown: No other argument is allowed.

            Raises:
                InputError: q has another shape or is out of range, or ``out`` does not fit.
            """
            fits = not unknown and (out is None or (type(out) is np.ndarray and out.flags.carray))
            if fits and type(q) is np.ndarray and q.ndim == 1 and q.dtype is FLOAT64:
                one = q if q.flags.carray else q.copy()  # a read-only array, such as robot.home, would be of another type
                result = np.empty(self._shape) if out is None else out
                try:
                    if self._one(*self._leading, one, result):
                        return result
                except TypeError:  # ``out`` has another type. Raising takes 80 us, so q's type is tested before the call.
                    pass
            return self._validated(q, out, **unknown)

    def _validated(self, q: ArrayLike, out: Array | None = None, **unknown: Never) -> Array:
        """The result for a batch, and for arguments that need a conversion or an error."""
        if unknown:
            refuse_unknown(type(self).__name__, unknown)
        q = as_positions(q, self._tree)
        result = as_out(out, (*q.shape[:-1], *self._shape), q)
        if q.ndim == 1:
            x = for_kernel(q)
            good = result.size == 0 or self._one(*self._leading[:-1], len(x), x, result)
        else:
            leading, rows = (self._tree.chain(self._link), *self._leading[1:-1]), flat(q)
            of_rows = result.reshape(len(rows), *self._shape)
            good = in_parts(lambda part: self._batch(*leading, rows[part], of_rows[part]), len(rows), MIN_POSES)
        if not good:
            refuse_out_of_range(q)
        return result


class CompiledForward(FunctionOfLink):
    """The pose of one link, shape (..., 4, 4), for a control loop: ``robot.compile_forward(link)``.

    It validates its arguments like ``robot.forward_kinematics``, in less time. It can be pickled, and called from many threads at
    once if each has its own ``out``.
    """

    __slots__ = ()

    def __init__(self, tree: Tree, link: str) -> None:
        super().__init__(tree, link, forward.forward_one, forward.forward_batch, (), _SHAPE)

    def __reduce__(self):
        return CompiledForward, (self._tree, self._link)

    def __repr__(self) -> str:
        return f"<CompiledForward {self._link!r}, {self._tree.n_dof} dof>"


class ForwardByLink(dict[str | None, CompiledForward]):
    """Forward kinematics of one robot by link, each compiled at its first use; None is the tip.

    A dict, because a dict look-up is the fastest way from ``robot.forward_kinematics(q)`` to the function.
    """

    def __init__(self, tree: Tree) -> None:
        super().__init__()
        self._tree = tree

    def of(self, link: str | None) -> CompiledForward:
        """Forward kinematics of a link. If two threads make it at once, both get the first.

        Raises:
            UnknownNameError: There is no such link.
        """
        name = self._tree.link_or_tip(link)
        self._tree.chain(name)  # raises an error for an unknown link
        function = self.get(name) or self.setdefault(name, CompiledForward(self._tree, name))
        return self.setdefault(link, function)


def forward_kinematics(tree: Tree, q: ArrayLike, link: str) -> Array:
    """T_base_link, shape (..., 4, 4), for q of shape (..., n_dof)."""
    return CompiledForward(tree, link)(q)


def frame_poses(tree: Tree, frames: Array, q: ArrayLike, out: Array | None = None) -> Array:
    """T_base_frame of every row of a table of frames, shape (..., n_frames, 4, 4), for q of shape (..., n_dof)."""
    q, n = as_positions(q, tree), len(frames)
    if q.ndim == 1:
        poses = np.empty((n, 4, 4)) if out is None else as_out(out, (n, 4, 4), q)
        good = forward.frames_one(tree.joints, frames, for_kernel(q), poses)
    else:
        poses = as_out(out, (*q.shape[:-1], n, 4, 4), q)
        rows = flat(q)
        of_rows = poses.reshape(len(rows), n, 4, 4)

        def run(part: slice) -> bool:
            return forward.frames_batch(tree.joints, frames, rows[part], of_rows[part])

        good = in_parts(run, len(rows), MIN_POSES)
    if not good:
        refuse_out_of_range(q)
    return poses
