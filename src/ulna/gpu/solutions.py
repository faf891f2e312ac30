"""Finds all solutions of targets on a GPU, one branch per thread, and holds solutions that stay there.

With an exact closed form for six joints, arrays on the device stay there. For other arms the CPU prepares the targets (seven
joints: one for each position of the held joint) and shifts the branches into the limits, so arrays are copied. Arms without a
closed form, or with an approximate one, are searched by the CPU. So the results equal those of the CPU.

The eight branches of a target are in adjacent threads, like the eight lanes of a vector on the CPU for one target. A single
thread for all of them would need more registers than there are (3 kB spilled; now none).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_switch
from ulna.description.pose import as_pose
from ulna.engine.decorators import kernel
from ulna.gpu import device, staged
from ulna.gpu.device_array import as_shaped
from ulna.gpu.queue import Queue
from ulna.ik.all_solutions import AllSolutions
from ulna.ik.closed_form.closed_form import N_AXES, ClosedForm, SixJoints, closed_form_of, joints_at
from ulna.ik.closed_form.six_joints import proofs_of
from ulna.ik.entries.branch_rows import move_to_limits, polish_branches, write_free_angles
from ulna.ik.entries.closed_form import N_OPTIONS
from ulna.ik.problem import Query
from ulna.ik.reason import Reason
from ulna.ik.solutions import PROOFS, IKSolutions, Proof
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.closed_form_layout import IS_REAL, IS_WITHIN, N_BRANCHES, N_KNOWN
from ulna.kernels.chain.closed_form_rows import properties_in_one
from ulna.kernels.ik.nearest_branch import is_any_hardly_beyond, turn_within
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect

Array = NDArray[np.float64]
_PROOFS = np.array(PROOFS)
_N_SIGNS, _FREE, _OF_JACOBIAN = 3, 2 * N_AXES, 6 * N_AXES


class DeviceSolutions(IKSolutions):
    """``IKSolutions`` with q, valid and real on the device; ``proof`` is computed on the host at the first access."""

    q: Any
    valid: Any
    real: Any
    _proofs: Callable[[], Any]

    def __init__(self, q: Any, valid: Any, real: Any, family: str, proofs: Callable[[], Any]) -> None:
        self.__dict__.update(q=q, valid=valid, real=real, family=family, _proofs=proofs)

    @cached_property
    def proof(self) -> Proof | NDArray[Any]:  # pyright: ignore[reportIncompatibleVariableOverride] - it is as read-only
        """The proof for each target, shape (...); for one target a ``Proof``."""
        return self._proofs()

    def copy_to_host(self) -> IKSolutions:
        """Copy the solutions to NumPy arrays."""
        q, valid, real = (device.on_host(array) for array in (self.q, self.valid, self.real))
        return IKSolutions(q, valid, real, self.proof, self.family)

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether there is a valid solution, shape (...), on the host."""
        return self.copy_to_host().success

    @property
    def reason(self) -> Reason:
        """For one target: the reason why no solution is valid, if so."""
        return self.copy_to_host().reason

    def __str__(self) -> str:
        return str(self.copy_to_host())


class Asked(NamedTuple):
    """The arguments of ``Robot.all_solutions``."""

    redundancy: str | None
    n_samples: int
    whole_turns: bool


def all_solutions(query: Query, T: Any, rows: Any, asked: Asked, queue: Queue) -> IKSolutions:
    """Find all solutions; see ``Robot.all_solutions``. The results are NumPy's, or Numba's on the device, like T.

    rows: Makes rows of an array on the device, as ``device.as_device_rows``.
    """
    redundancy, n_samples, whole_turns = asked.redundancy, asked.n_samples, as_switch("whole_turns", asked.whole_turns)
    every = AllSolutions(query, redundancy, partial(_branches, queue))
    if not device.is_on_device(T):
        return every.all_solutions(T, n_samples, whole_turns=whole_turns)
    targets = rows("T", T, (4, 4))
    batch = tuple(T.shape[:-2])
    form = None if whole_turns or redundancy is not None else _of_all_joints(query)
    if form is not None:
        return _staying(query, form, targets, batch, queue)
    found = every.all_solutions(device.on_host(targets, queue.stream).reshape(*batch, 4, 4), n_samples, whole_turns=whole_turns)
    q, valid, real = (device.on_device(array, queue.stream) for array in (found.q, found.valid, found.real))
    return DeviceSolutions(q, valid, real, found.family, lambda: found.proof)


def _of_all_joints(query: Query) -> ClosedForm | None:
    """The exact form of an arm with six joints and no others, for full poses; None for other arms."""
    form = closed_form_of(query.tree, query.link, task=query.options.task)
    if form is None or not form.is_exact or query.task_axes is not None:
        return None
    return form if form.n_joints == N_AXES == query.tree.n_dof and not form.couplings else None


def _staying(query: Query, form: ClosedForm, targets: Any, batch: tuple[int, ...], queue: Queue) -> DeviceSolutions:
    """The branches of targets (n, 4, 4) on the device, left there."""
    six = joints_at(form, query.home)
    seeds, plan = query.home[six.columns][None], six.plan(query.tree.lower, query.tree.upper)
    q, known, real, valid = _run(queue, six, targets, seeds, plan, six.columns)

    def proofs() -> Proof | NDArray[Any]:
        bits = device.on_host(known)
        proof = _PROOFS[proofs_of(bits, (bits & IS_REAL) > 0)].reshape(batch)
        return proof if batch else Proof(str(proof))

    shape = *batch, N_BRANCHES
    return DeviceSolutions(as_shaped(q, (*shape, N_AXES)), as_shaped(valid, shape), as_shaped(real, shape), form.geometry, proofs)


def _branches(queue: Queue, six: SixJoints, targets: Array, seeds: Array, plan: Array) -> tuple[Any, Any, Any]:
    """``SixJoints.branches``, by the GPU."""
    q, known, _, _ = _run(queue, six, targets, seeds, plan, np.arange(N_AXES))
    return q, known, proofs_of(known, (known & IS_REAL) > 0)


def _run(queue: Queue, six: SixJoints, targets: Any, seeds: Array, plan: Array, columns: NDArray[np.int64]) -> tuple[Any, ...]:
    """q (n, 8, 6), the bits of each branch, real and valid, (n, 8), on the side of the targets."""
    n, stream = len(targets), queue.stream
    kinds = ((N_AXES,), np.float64), ((), np.int8), ((), np.bool_), ((), np.bool_)
    results = tuple(device.results_for(targets, (N_BRANCHES * n, *shape), dtype, stream) for shape, dtype in kinds)
    tables = tuple(device.on_device(array, stream) for array in (six.table, six.chain, plan, columns, seeds))
    device.run(branches_of(), tables, targets, results, queue.marks(), device.Launch(each=N_BRANCHES, stream=stream))
    queue.launched(lambda: _refuse(device.on_host(targets)), is_done=not device.is_on_device(targets))
    return tuple(as_shaped(array, (n, N_BRANCHES, *shape)) for array, (shape, _) in zip(results, kinds, strict=True))


def _refuse(targets: Array) -> None:
    as_pose(targets)


@cache
def branches_of() -> Any:
    """The driver of all branches: rows of q, and the bits of each, in adjacent threads.

    tables: (table, chain, plan, columns, seeds), as for ``ik.entries.closed_form.all_branches``; columns: the entry of q of each
    joint. marks: the flag, the bits, whether a branch reaches the target, and whether it is also within the bounds.
    """
    return staged.over_rows(_branch, None, N_AXES, each=N_BRANCHES)


@kernel
def _branch(tables, matrix, place, _own, q_out, marks):
    """Write one branch of a target and its bits; returns whether the target is no rigid motion."""
    table, chain, plan, columns, seeds = tables
    _, known_out, real, valid = marks
    thread = place[0]
    branch, seed, bounds = thread % N_BRANCHES, seeds[min(thread // N_BRANCHES, seeds.shape[0] - 1)], plan[N_OPTIONS:]
    signs, free = staged.cuda.local.array(_N_SIGNS, np.float64), staged.cuda.local.array(_FREE, np.float64)
    target, q = staged.cuda.local.array(12, np.float64), staged.cuda.local.array(N_AXES, np.float64)
    known, jacobian = staged.cuda.local.array(N_KNOWN, np.float64), staged.cuda.local.array(_OF_JACOBIAN, np.float64)
    system, last = staged.cuda.local.array(N_SYSTEM, np.float64), staged.cuda.local.array(N_AXES, np.float64)
    inside, error = staged.cuda.local.array(N_AXES, np.float64), staged.cuda.local.array(1, np.float64)
    for k in range(_N_SIGNS):
        signs[k] = 1.0 - 2.0 * ((branch >> (_N_SIGNS - 1 - k)) & 1)
    pose = matrix_pose(matrix)
    for k in range(12):
        target[k] = pose[k]
    write_free_angles(table, seed, free)
    closed_form(table, target, signs, 1, free, q, known)
    polish_branches(table, chain, (signs, free, target, q, known), (jacobian, system, last))
    if bounds.shape[0] > 0 and is_any_hardly_beyond(q, known, bounds):
        move_to_limits(table, chain, (signs, free, target, q, known), (jacobian, system, last), (seed, bounds), (inside, error))
    known[0] = properties_in_one(known, 0)
    if bounds.shape[0] > 0:
        turn_within(q, known, 0, seed, bounds)
    bits = int(known[0])
    known_out[thread], real[thread], valid[thread] = bits, (bits & IS_REAL) > 0, (bits & IS_WITHIN) > 0
    for j in range(N_AXES):
        q_out[columns[j]] = q[j]
    return not rigidity_defect(matrix) <= LARGEST_DEFECT
