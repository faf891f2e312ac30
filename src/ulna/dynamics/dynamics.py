"""Computes torques, accelerations, the mass matrix and quantities derived from them, NumPy in and out."""

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.robot_description import Description, Inertia, frozen
from ulna.description.shapes import within_reach
from ulna.dynamics.bodies import mechanism_of, point_mass
from ulna.dynamics.effort import as_effort_limits, max_payloads
from ulna.dynamics.entries import masses, torques
from ulna.engine.bound import bind
from ulna.engine.entries import ready
from ulna.engine.threads import MIN_ROWS, in_parts
from ulna.errors import InertiaError, InputError, SingularityError
from ulna.kernels.dynamics.dynamics_records import MOTION_WIDTH, ForceRows, Mechanism
from ulna.kernels.layout import INERTIA_WIDTH, MASS
from ulna.kinematics.jacobian import geometric_jacobian
from ulna.kinematics.positions import FLOAT64, as_out, as_positions, flat, refuse_out_of_range
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
Wrenches = Mapping[str, ArrayLike]
FREE_FALL = frozen((0.0, 0.0, -9.81), (3,))
"""The gravitational acceleration [m/s^2] of an upright arm: Pinocchio's value; standard gravity is 9.80665."""
_MIN_RATIO = 1e-12  # least to greatest eigenvalue of J M^-1 J': below it the matrix counts as singular


class Dynamics:
    """The dynamics of a robot; ``Robot`` has the documentation of the methods of the same names."""

    def __init__(self, tree: Tree, description: Description, inertias: Iterable[tuple[str, Inertia]], gravity: Array) -> None:
        """Take a robot, and the inertias of its links and attached objects, each with its link's name."""
        self._tree, self._description, self._inertias = tree, description, tuple(inertias)
        self.gravity = gravity

    @cached_property
    def mechanism(self) -> Mechanism:
        """The joints, and the inertias of the bodies that they carry.

        Raises:
            InertiaError: A moving link has a shape but no inertia; or no moving link has an inertia.
        """
        return mechanism_of(self._tree, self._description.links, self._inertias)

    @cached_property
    def one(self) -> Callable[..., Array]:
        """A fast function for the torques of one q, qd and qdd, shape (n_dof,) each, in the robot's own gravity.

        It passes other arguments on to ``inverse``.

        Raises:
            InertiaError: See ``mechanism``.
        """
        n, entry = self._tree.n_dof, ready(torques.inverse_one)
        k = len(self.mechanism.joints)
        rows = ForceRows(np.empty(MOTION_WIDTH * (k + 1)), np.empty(12 * k), np.empty(6 * k))
        leading = self.mechanism, self.gravity, rows, np.zeros(2 * k)
        shape = self._tree.q_shape

        def validated(q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
            if all(type(x) is np.ndarray and x.dtype is FLOAT64 and x.shape == shape and x.flags.carray for x in (q, qd, qdd)):
                torque = np.empty(n)
                if n and entry(*leading, q, qd, qdd, torque):
                    return torque
            return self.inverse((q, qd, qdd), None, None, None)

        return bind(entry, "motion", leading, n, (n,), validated)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in {"mechanism", "one"}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the unpickled gravity read-only: for a writable array, the entries would be compiled a second time."""
        self.__dict__.update(state)
        self.gravity = frozen(self.gravity, (3,))

    def inverse(
        self, motion: tuple[ArrayLike, ...], gravity: ArrayLike | None, wrenches: Wrenches | None, out: Array | None
    ) -> Array:
        """The torques of q, qd and qdd."""
        leading = self.mechanism, self.free_fall(gravity)
        torque = self._run(torques.inverse_batch, leading, dict(zip(("q", "qd", "qdd"), motion, strict=True)), out)
        self._subtract_wrenches(torque, motion[0], wrenches)
        return torque

    def gravity_torque(self, q: ArrayLike, gravity: ArrayLike | None, out: Array | None) -> Array:
        """The torques that hold the robot still, shape (..., n_dof)."""
        return self._run(torques.gravity_batch, (self.mechanism, self.free_fall(gravity)), {"q": q}, out)

    def payload(
        self,
        motion: Mapping[str, ArrayLike | None],
        held: tuple[str | None, ArrayLike],
        torque: ArrayLike,
        gravity: ArrayLike | None,
    ) -> Array:
        """The maximum payload of each motor at a point of a link, shape (..., n_dof).

        motion: q, qd and qdd; None for qd or qdd means zero. held: the link and the point.
        """
        most, free_fall = as_effort_limits(torque, self._tree), self.free_fall(gravity)
        link, center = self._tree.link_or_tip(held[0]), within_reach("com", held[1])
        if center.shape != (3,):
            raise InputError("com", f"shape {center.shape}; three numbers [m] are expected")
        self._tree.chain(link)  # raises an error if there is no such link
        at_rest = motion["qd"] is None and motion["qdd"] is None
        given = {name: np.zeros(self._tree.n_dof) if each is None else each for name, each in motion.items()}
        entry, given = (torques.gravity_batch, {"q": given["q"]}) if at_rest else (torques.inverse_batch, given)
        own = self._run(entry, (self.mechanism, free_fall), given, None)
        of_one_kilogram = self._run(entry, (point_mass(self._tree, link, center), free_fall), given, None)
        return max_payloads(own, of_one_kilogram, most)

    def forward(
        self, q: ArrayLike, qd: ArrayLike, torque: ArrayLike, load: tuple[ArrayLike | None, Wrenches | None, Array | None]
    ) -> Array:
        """The accelerations that torques cause, shape (..., n_dof). load: gravity, wrenches and ``out``."""
        gravity, wrenches, out = load
        if wrenches:
            batch, _ = self.rows({"q": q, "qd": qd, "torque": torque})
            of_wrenches = np.zeros((*batch, self._tree.n_dof))
            self._subtract_wrenches(of_wrenches, q, wrenches)
            torque = as_positions(torque, self._tree, "torque") - of_wrenches
        leading = self.mechanism, self.free_fall(gravity)
        made = self._run(masses.forward_batch, leading, {"q": q, "qd": qd, "torque": torque}, out)
        is_nan = np.isnan(made)
        if is_nan.any():  # for all rows at once: a test per row would take an eighth of the call
            raise massless(np.asarray(is_nan.any(axis=-1)))
        return made

    def mass_matrix(self, q: ArrayLike, out: Array | None) -> Array:
        """The mass matrix, shape (..., n_dof, n_dof)."""
        n = self._tree.n_dof
        return self._run(masses.mass_batch, (self.mechanism,), {"q": q}, out, (n, n))

    def derivatives(
        self, motion: tuple[ArrayLike, ...], gravity: ArrayLike | None, out: Array | None = None
    ) -> tuple[Array, Array]:
        """The derivatives of the torques with respect to q and to qd, shape (..., n_dof, n_dof) each."""
        n, leading = self._tree.n_dof, (self.mechanism, self.free_fall(gravity))
        batch, given = self.rows(dict(zip(("q", "qd", "qdd"), motion, strict=True)))
        by_q, by_rate = as_out(out, (2, *batch, n, n), *given.values())
        self._in_parts(torques.derivatives_batch, leading, given, [by_q.reshape(-1, n, n), by_rate.reshape(-1, n, n)])
        return by_q, by_rate

    def external(self, measured: ArrayLike, motion: tuple[ArrayLike, ...], gravity: ArrayLike | None) -> Array:
        """Measured torques minus the torques of a motion."""
        given = as_positions(measured, self._tree, "measured")
        _refuse_infinite(given, "measured")
        torque = self.inverse(motion, gravity, None, None)
        try:
            return given - torque
        except ValueError:
            raise InputError("measured", f"shape {given.shape} does not go with torques of shape {torque.shape}") from None

    def center_of_mass(self, q: ArrayLike, out: Array | None) -> Array:
        """The center of mass of all moving bodies in the base, shape (..., 3)."""
        moments, _ = self._moments(q)
        made = as_out(out, (*moments.shape[:-1], 3))
        np.divide(moments[..., 1:], moments[..., :1], out=made)
        return made

    def center_of_mass_jacobian(self, q: ArrayLike) -> Array:
        """The Jacobian of the center of mass, shape (..., 3, n_dof)."""
        moments, columns = self._moments(q)
        return np.swapaxes(columns, -1, -2) / moments[..., :1, None]

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike) -> Any:
        """The kinetic energy 1/2 qd' M qd, shape (...)."""
        self.rows({"q": q, "qd": qd})  # raises an error for shapes that do not broadcast
        qd = as_positions(qd, self._tree, "qd")
        _refuse_infinite(qd, "qd")
        return 0.5 * np.einsum("...i,...ij,...j->...", qd, self.mass_matrix(q, None), qd)

    def potential_energy(self, q: ArrayLike, gravity: ArrayLike | None) -> Any:
        """The potential energy -g . h, shape (...), with the first moment h of all moving bodies."""
        moments, _ = self._moments(q)
        return -(moments[..., 1:] @ self.free_fall(gravity))

    def operational_inertia(self, q: ArrayLike, link: str) -> Array:
        """The operational-space inertia (J M^-1 J')^-1, shape (..., 6, 6)."""
        q = as_positions(q, self._tree)
        J, M = geometric_jacobian(self._tree, q, link, "base"), self.mass_matrix(q, None)
        try:
            mobility = J @ np.linalg.solve(M, np.swapaxes(J, -1, -2))
        except np.linalg.LinAlgError:
            raise massless(np.ones(q.shape[:-1], bool)) from None
        sizes = np.linalg.eigvalsh(mobility)
        locked = ~(sizes[..., 0] > _MIN_RATIO * sizes[..., -1])
        if locked.any():
            raise _singularity_error(f"no joint moves {link!r} in some direction, where its inertia is infinite", locked)
        return np.linalg.inv(mobility).astype(np.float64, copy=False)

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, gravity: ArrayLike | None) -> Array:
        """The torques per unit of each inertial parameter, shape (..., n_dof, n_bodies, 10)."""
        joints, free_fall, units = self._tree.joints, self.free_fall(gravity), len(self._tree.joints) * INERTIA_WIDTH
        batch, given = self.rows({"q": q, "qd": qd, "qdd": qdd})
        made = np.empty((units, *batch, self._tree.n_dof))
        for unit, torque in enumerate(made):
            table = np.zeros((len(joints), INERTIA_WIDTH))
            table.flat[unit] = 1.0
            leading = Mechanism(joints, frozen(table, table.shape)), free_fall
            self._in_parts(torques.inverse_batch, leading, given, [torque.reshape(-1, self._tree.n_dof)])
        return np.moveaxis(made, 0, -1).reshape(*batch, self._tree.n_dof, len(joints), INERTIA_WIDTH)

    def _moments(self, q: ArrayLike) -> tuple[Array, Array]:
        n = self._tree.n_dof
        batch, given = self.rows({"q": q})
        if not self.mechanism.bodies[:, MASS].any():
            raise InertiaError("it has no center of mass: the links that joints move have no mass", self._tree.link_names)
        moments, columns = np.empty((*batch, 4)), np.empty((*batch, n, 3))
        self._in_parts(masses.moment_batch, (self.mechanism,), given, [moments.reshape(-1, 4), columns.reshape(-1, n, 3)])
        return moments, columns

    def free_fall(self, gravity: ArrayLike | None) -> Array:
        """The given gravitational acceleration [m/s^2], or the robot's own if None."""
        return self.gravity if gravity is None else as_gravity(gravity)

    def rows(self, given: dict[str, ArrayLike]) -> tuple[tuple[int, ...], dict[str, Array]]:
        """The broadcast batch shape of all arguments, and the rows of each argument."""
        arrays = {name: as_positions(value, self._tree, name) for name, value in given.items()}
        shapes = {array.shape for array in arrays.values()}
        if len(shapes) == 1:  # the most frequent case
            return shapes.pop()[:-1], {name: flat(array) for name, array in arrays.items()}
        try:
            batch = np.broadcast_shapes(*(shape[:-1] for shape in shapes))
        except ValueError:
            name = list(arrays)[-1]
            raise InputError(
                name, f"shapes {', '.join(f'{key} {array.shape}' for key, array in arrays.items())} do not go together"
            ) from None
        return batch, {
            name: flat(array if array.shape[:-1] == batch else _broadcast(array, batch)) for name, array in arrays.items()
        }

    def _run(
        self,
        entry: Callable[..., bool],
        leading: tuple,
        given: dict[str, ArrayLike],
        out: Array | None,
        shape: tuple[int, ...] = (),
    ) -> Array:
        batch, rows = self.rows(given)
        made = as_out(out, (*batch, *(shape or self._tree.q_shape)), *rows.values())
        self._in_parts(entry, leading, rows, [made.reshape(-1, *made.shape[len(batch) :])])
        return made

    def _in_parts(self, entry: Callable[..., bool], leading: tuple, rows: dict[str, Array], made: list[Array]) -> None:
        n = len(made[0])
        if not in_parts(lambda part: entry(*leading, *(each[part] for each in (*rows.values(), *made))), n, MIN_ROWS):
            refuse_rows(rows)

    def _subtract_wrenches(self, torque: Array, q: ArrayLike, wrenches: Wrenches | None) -> None:
        """Subtract J' w of each link from the torques, in place."""
        if wrenches is not None and not isinstance(wrenches, Mapping):
            raise InputError("wrenches", f"{type(wrenches).__name__}; forces and moments by link are expected, as {{'tool': w}}")
        for link, given in (wrenches or {}).items():
            wrench = as_floats("wrenches", given)
            if wrench.shape[-1:] != (6,):
                raise InputError(
                    "wrenches", f"shape {wrench.shape} for {link!r}; forces and moments, shape (..., 6), are expected"
                )
            _refuse_infinite(wrench, "wrenches")
            J = geometric_jacobian(self._tree, q, link, "base")
            try:
                torque -= np.einsum("...ij,...i->...j", J, wrench)
            except ValueError:
                raise InputError(
                    "wrenches", f"shape {wrench.shape} for {link!r} does not go with q of shape {np.shape(q)}"
                ) from None


def as_gravity(gravity: ArrayLike) -> Array:
    """Check a gravitational acceleration: three finite numbers."""
    vector = as_floats("gravity", gravity)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(
            "gravity", f"{gravity!r}; three finite numbers [m/s^2] in the axes of the base are expected, as (0, 0, -9.81)"
        )
    return frozen(vector, (3,))


def refuse_rows(rows: Mapping[str, Array]) -> None:
    """Raise the error of the first named argument that is out of range or not finite, if there is one."""
    for name, each in rows.items():
        refuse_out_of_range(each, name) if name == "q" else _refuse_infinite(each, name)


def _broadcast(array: Array, batch: tuple[int, ...]) -> Array:
    return np.array(np.broadcast_to(array, (*batch, array.shape[-1])), order="C")


def _refuse_infinite(values: Array, name: str) -> None:
    if not np.isfinite(values).all():
        bad = np.argwhere(~np.isfinite(values))[0]
        raise InputError(f"{name}[{', '.join(str(int(k)) for k in bad)}]", f"{values[tuple(bad)]} is not a finite number")


def massless(rows: NDArray[np.bool_]) -> SingularityError:
    """The error for rows with a singular mass matrix."""
    return _singularity_error("the mass matrix is singular: a joint moves no mass", rows)


def _singularity_error(message: str, rows: NDArray[np.bool_]) -> SingularityError:
    return SingularityError(message, tuple(map(tuple, np.argwhere(rows).tolist())))
