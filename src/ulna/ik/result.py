"""Holds the configurations that a search found, their errors, and the reason for an unreached target."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import TruthError, count_of
from ulna.ik.reason import NO_REASON, NOTHING_TO_EXPLAIN, Explanation, Reason
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_records import Results
from ulna.notebook.tables import table

Array = NDArray[np.float64]


class Status(StrEnum):
    """The outcome of a search."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    JOINT_LIMITS = "joint limits"
    BEYOND_MAX_STEP = "beyond max_step"
    HELD_JOINTS = "held joints"
    IN_COLLISION = "in collision"
    SINGULAR = "singular"
    BUDGET_SPENT = "budget spent"
    NOT_FOUND = "not found"


# The kernels' codes, then those that only an explanation sets.
CODES = {
    Status.SOLVED: layout.SOLVED,
    Status.NOT_FOUND: layout.NOT_FOUND,
    Status.UNREACHABLE: 10,
    Status.JOINT_LIMITS: 11,
    Status.BEYOND_MAX_STEP: 12,
    Status.IN_COLLISION: 13,
    Status.HELD_JOINTS: 16,
    Status.SINGULAR: 14,
    Status.BUDGET_SPENT: 15,
}
_NARROWED = {
    Status.JOINT_LIMITS: "found only beyond the limits",
    Status.BEYOND_MAX_STEP: "found only beyond max_step",
    Status.HELD_JOINTS: "found only with held joints moved",
}
_WORDS = {
    Status.SINGULAR: "the arm cannot move in the direction of the remaining error",
    Status.BUDGET_SPENT: "the budget ran out",
    Status.NOT_FOUND: "no start led to the target",
}
_ROUNDING = 1e-9  # mm or degrees: a sentence rounds smaller values to 0
_OF_CODE = {code: status for status, code in CODES.items()}


class IKResult:
    """Configurations for targets of shape (..., 4, 4). For one target, ``bool(result)`` is True if it was reached.

    For a batch every attribute is an array of its shape (...,), and ``q`` has one more axis. For one target they are plain
    values. If no solution is found, ``success`` is False and ``q`` is the best configuration found, within the limits. The best
    one minimizes |displacement|^2 [m^2] + |rotation|^2 [rad^2] over the components that the task requires. Arms of less than 1/32
    m or more than 32 m use a unit of their own.

    ========================= ========================================================================================
    ``solved``                The errors that the task counts are within the tolerances.
    ``unreachable``           A certificate: the target lies outside the arm's reach, by at least ``reach_excess``. If that
                              is 0, the closed form proves that there is no solution, whatever the limits.
    ``joint limits``          Solutions found, all beyond the limits; ``limit_excess`` holds the excess of each joint.
    ``beyond max_step``       Solutions found, all beyond ``max_step``; ``limit_excess`` holds the excess.
    ``held joints``           Solutions found, all with held joints moved; ``limit_excess`` holds the motion.
    ``in collision``          Every configuration found collides; ``collisions`` names the pairs.
    ``singular``              Limits aside, no joint reduces the error to first order: |J' e| < 0.001 |J| |e|.
    ``budget spent``          ``max_iterations`` or ``time_limit`` ran out before the default number of starts was tried.
    ``not found``             None of these: ``q`` is the best configuration found.
    ========================= ========================================================================================
    """

    __slots__ = ("_batch", "explanation", "info", "q", "tolerances")

    q: Array
    """Joint positions [rad or m], shape (..., n_dof), always within the limits."""
    tolerances: tuple[float, float]
    """The maximum errors that count as reached [m, rad]."""
    info: Results
    """The kernels' record of each target (``kernels.ik.search_records``), shape (n,)."""
    explanation: Explanation
    """The details of the targets that were not reached."""

    def __init__(
        self,
        q: Array,
        info: Results,
        batch: tuple[int, ...],
        tolerances: tuple[float, float],
        explanation: Explanation = NOTHING_TO_EXPLAIN,
    ) -> None:
        put = object.__setattr__
        put(self, "q", q)
        put(self, "info", info)
        put(self, "_batch", batch)
        put(self, "tolerances", tolerances)
        put(self, "explanation", explanation)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"an IKResult cannot be changed: {name} = {value!r}")

    def __reduce__(self):
        return IKResult, (self.q, self.info, self._batch, self.tolerances, self.explanation)

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether the errors that the task counts are within the tolerances."""
        found = self.info["status"] == layout.SOLVED
        return found.reshape(self._batch) if self._batch else bool(found[0])

    @property
    def status(self) -> Status | NDArray[np.str_]:
        """The outcome of the search; see above."""
        if not self._batch:
            return _OF_CODE[self.info["status"][0]]
        words = np.empty(len(self.info), dtype="<U16")
        for code, word in _OF_CODE.items():
            words[self.info["status"] == code] = word
        return words.reshape(self._batch)

    @property
    def position_error(self) -> float | Array:
        """Distance of the link's origin from the target's [m], by forward kinematics of ``q``, for any task."""
        return self._field("position_error")

    @property
    def rotation_error(self) -> float | Array:
        """Angle of the remaining rotation [rad], for any task: it includes rotations that the task leaves free."""
        return self._field("rotation_error")

    @property
    def residual(self) -> Array:
        """The pose error by component, shape (..., 6): x, y, z [m], rotation vector [rad], in the target's axes."""
        return self._residual(self.explanation.task_axes)

    def _residual(self, R: Array | None) -> Array:
        rows = self.info["residual"]
        if R is not None:
            rows = np.hstack([rows[:, :3] @ R.T, rows[:, 3:] @ R.T])
        return rows.reshape(*self._batch, 6).copy()

    @property
    def iterations(self) -> int | NDArray[np.int64]:
        """Steps from the start that led to ``q``. For results found beyond the limits, steps since they were moved within."""
        steps = self.info["iterations"]
        return steps.reshape(self._batch).copy() if self._batch else int(steps[0])

    @property
    def starts(self) -> int | NDArray[np.int64]:
        """The number of the start that led to ``q``: 1 is the seed, the others are random."""
        starts = self.info["start"] + 1
        return starts.reshape(self._batch) if self._batch else int(starts[0])

    @property
    def reach_excess(self) -> float | Array:
        """The distance of the target, with its orientation, from the arm's reach [m]; 0 if not proved."""
        return self._by_target(self.explanation.reach_excess, ())

    @property
    def limit_excess(self) -> Array:
        """The excess of each joint over its limit, or over ``max_step`` [rad or m], (..., n_dof); 0 if unknown."""
        return self._by_target(self.explanation.limit_excess, self.q.shape[-1:])

    @property
    def collisions(self) -> tuple:
        """The pairs (name_a, name_b) that collide at the best configuration found; for a batch one tuple for each target."""
        pairs = self.explanation.collisions
        return tuple(pairs.get(i, ()) for i in range(len(self.info))) if self._batch else pairs.get(0, ())

    @property
    def has_trace(self) -> bool:
        """Whether a trace was recorded."""
        return self.explanation.trace is not None

    @property
    def trace(self) -> Array:
        """With ``trace=True``, one row a step: position error [m], rotation error [rad], largest joint step [rad or m], damping.

        For an unsolved target it ends at the end of the best start.

        Raises:
            AttributeError: No trace was recorded.
        """
        if self.explanation.trace is None:
            raise AttributeError("there is no trace: ask for one by inverse_kinematics(..., trace=True)")
        return self.explanation.trace

    @property
    def reason(self) -> Reason:
        """For one target: the reason why it was not reached; else no reason."""
        return NO_REASON if self._batch or self.success else _reason(self)

    def __bool__(self) -> bool:
        if self._batch:
            raise TruthError("an IKResult", "result.success")
        return bool(self.success)

    def __str__(self) -> str:
        return _many_as_text(self) if self._batch else _one_as_text(self)

    def __repr__(self) -> str:
        return f"<IKResult: {self}>"

    def _repr_html_(self) -> str:
        if self._batch:
            words, counts = np.unique(np.ravel(self.status), return_counts=True)
            return table(repr(self)[1:-1], ("status", "targets"), zip(words.tolist(), counts.tolist(), strict=True))
        names = self.explanation.entry_names or [f"q[{k}]" for k in range(len(self.q))]
        return table(repr(self)[1:-1], ("joint", "q [rad or m]"), zip(names, self.q.tolist(), strict=True))

    def _field(self, name: str) -> Any:
        return self.info[name].reshape(self._batch).copy() if self._batch else float(self.info[name][0])

    def _by_target(self, known: Mapping[int, Any], shape: tuple[int, ...]) -> Any:
        values = np.zeros((len(self.info), *shape))
        for i, value in known.items():
            values[i] = value
        return values.reshape(*self._batch, *shape) if self._batch or shape else float(values[0])


def _reason(result: IKResult) -> Reason:
    status, known = Status(str(result.status)), result.explanation
    if status == Status.UNREACHABLE:
        missing = f"; it misses the target by {result.reach_excess:.3g} m" if result.reach_excess else ""
        return Reason(known.reach + missing, {"reach_excess": result.reach_excess})
    if status in _NARROWED:
        beyond = {name: float(x) for name, x in zip(known.entry_names, result.limit_excess, strict=True) if x > 0}
        words = ", ".join(f"{name} by {x:.3g}" for name, x in beyond.items())
        return Reason(f"{_NARROWED[status]}: {words}", {"limit_excess": beyond})
    if status == Status.IN_COLLISION:
        words = ", ".join(f"{a} hits {b}" for a, b in result.collisions[:4])
        return Reason(words, {"collisions": result.collisions})
    return Reason(_WORDS.get(status, ""), {})


def _one_as_text(result: IKResult) -> str:
    position, rotation = (x if x > _ROUNDING else 0.0 for x in (result.position_error * 1e3, np.degrees(result.rotation_error)))
    errors = f"{position:.3g} mm and {rotation:.3g} deg from the target"
    steps = f"after {count_of(int(result.iterations), 'step')}"
    if result.success:
        return (
            f"solved: within what the task allows, {errors}, {steps}" if _is_off_target(result) else f"solved: {errors} {steps}"
        )
    return f"{result.status}: {f'{result.reason}; ' if result.reason else ''}the best is {errors}"


def _many_as_text(result: IKResult) -> str:
    status = np.ravel(result.status)
    solved = int(np.count_nonzero(status == Status.SOLVED))
    worst = [f"{np.max(errors, initial=0.0):.3g}" for errors in (result.position_error, result.rotation_error)]
    others = [f"{np.count_nonzero(status == word)} {word}" for word in Status if word != Status.SOLVED and word in status]
    others_text = f" ({', '.join(others)})" if others else ""
    errors = "errors, with what the task allows," if _is_off_target(result) else "errors"
    return f"{solved} of {count_of(status.size, 'target')} solved{others_text}; largest {errors} {worst[0]} m, {worst[1]} rad"


def _is_off_target(result: IKResult) -> bool:
    """Whether the link at a solved target is off its pose by more than the tolerances, as the task allows."""
    is_off = np.stack([result.position_error, result.rotation_error], axis=-1) > result.tolerances
    return bool((is_off.any(axis=-1) & result.success).any())
