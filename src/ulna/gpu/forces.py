"""Defines the methods of a robot on a GPU that compute forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ulna.dynamics.dynamics import massless, refuse_rows
from ulna.errors import InputError
from ulna.gpu import device
from ulna.gpu.device_array import as_own, as_shaped
from ulna.gpu.queue import Queue
from ulna.gpu.search import OnHost
from ulna.gpu.torques import derivatives_of, forward_of, gravity_of, inverse_of, masses_of

Given = dict[str, Any]


class GpuForces:
    """The dynamics of a robot on a GPU: the methods of ``Robot`` of the same names, without wrenches.

    They compute in float64, for float32 input too. On the device all arguments of a call must have one shape.
    """

    robot: OnHost
    _queue: Queue
    _over_q: Callable[..., Any]
    _results: Callable[..., Any]
    _wide_rows: Callable[..., Any]
    _kept: Callable[..., Any]

    def inverse_dynamics(self, q: Any, qd: Any, qdd: Any, *, gravity: ArrayLike | None = None, out: Any = None) -> Any:
        """The torques that a motion needs [Nm or N], shape (..., n_dof); see ``Robot.inverse_dynamics``.

        Raises:
            InputError: An argument has another shape, is out of range or is not finite; or they are not on the same side.
            InertiaError: A link that moves and has a shape has no inertia.
        """
        return self._over_motion(inverse_of, {"q": q, "qd": qd, "qdd": qdd}, gravity, (self.robot.tree.q_shape,), out)[0]

    def gravity_torque(self, q: Any, *, gravity: ArrayLike | None = None, out: Any = None) -> Any:
        """The torques that hold the robot still [Nm or N], shape (..., n_dof); see ``Robot.gravity_torque``.

        Raises:
            InputError: As ``inverse_dynamics``.
            InertiaError: As ``inverse_dynamics``.
        """
        driver, shape = gravity_of(*self._sizes()), self.robot.tree.q_shape
        return self._over_q(driver, self._mechanism(gravity), q, shape, number=np.float64, out=out)

    def mass_matrix(self, q: Any, *, out: Any = None) -> Any:
        """The mass matrix M, shape (..., n_dof, n_dof); see ``Robot.mass_matrix``.

        Raises:
            InputError: As ``inverse_dynamics``.
            InertiaError: As ``inverse_dynamics``.
        """
        driver, shape = masses_of(*self._sizes()), self.robot.tree.q_shape * 2
        return self._over_q(driver, self._mechanism(None), q, shape, number=np.float64, out=out)

    def forward_dynamics(self, q: Any, qd: Any, torque: Any, *, gravity: ArrayLike | None = None, out: Any = None) -> Any:
        """The accelerations that torques cause [rad/s^2 or m/s^2], shape (..., n_dof); see ``Robot.forward_dynamics``.

        Raises:
            InputError: As ``inverse_dynamics``.
            InertiaError: As ``inverse_dynamics``.
            SingularityError: A joint moves no mass.
        """
        given = {"q": q, "qd": qd, "torque": torque}
        return self._over_motion(forward_of, given, gravity, (self.robot.tree.q_shape,), out)[0]

    def inverse_dynamics_derivatives(self, q: Any, qd: Any, qdd: Any, *, gravity: ArrayLike | None = None) -> tuple[Any, Any]:
        """The derivatives of the torques of a motion by q and by qd, shape (..., n_dof, n_dof) each.

        See ``Robot.inverse_dynamics_derivatives``.

        Raises:
            InputError: As ``inverse_dynamics``.
            InertiaError: As ``inverse_dynamics``.
        """
        shapes = (self.robot.tree.q_shape * 2,) * 2
        by_q, by_rate = self._over_motion(derivatives_of, {"q": q, "qd": qd, "qdd": qdd}, gravity, shapes, None)
        return by_q, by_rate

    # ---- parts ---------------------------------------------------------------------------------------------------------

    def _over_motion(
        self, driver_of: Callable[..., Any], given: Given, gravity: ArrayLike | None, shapes: Sequence[tuple[int, ...]], out: Any
    ) -> list[Any]:
        """The results of a driver for motions, shapes (..., *shape), on the side of the input.

        Args:
            driver_of: Makes the driver.
            given: q and the other arguments, by name.
            gravity: As of ``inverse_dynamics``.
            shapes: The shape of each result, for one motion.
            out: The caller's array for the first result, if given.
        """
        queue, tables = self._queue, self._mechanism(gravity)
        batch, rows = self._motion_rows(given)
        first, *others = rows.values()
        stays = device.is_on_device(first)
        # Arrays on the device stay three; arrays on the host are copied as one.
        tables, joined = ((*tables, tuple(others)), first) if stays else (tables, np.concatenate([first, *others], axis=1))
        results = [self._results(out, first, (*batch, *shape), np.dtype(np.float64)) for shape in shapes]
        flat_results = [as_shaped(each, (len(first), int(np.prod(shape)))) for each, shape in zip(results, shapes, strict=True)]

        def refuse() -> None:
            refuse_rows({name: device.on_host(each) for name, each in rows.items()})
            without_mass = np.asarray(np.isnan(device.on_host(results[0])).any(axis=-1))
            if without_mass.any():
                raise massless(without_mass)

        driver = driver_of(*self._sizes(), len(others) if stays else 0)
        device.run(driver, tables, joined, flat_results, queue.marks(), device.Launch(stream=queue.stream))
        queue.launched(refuse, is_done=not stays)
        return results if out is None else [out]

    def _motion_rows(self, given: Given) -> tuple[tuple[int, ...], Given]:
        """The common batch shape of all arguments, and the rows of each, on their side."""
        own = {name: as_own(name, each, self._queue.stream) for name, each in given.items()}
        places = {device.is_on_device(each) for each in own.values()}
        if places == {False}:
            return self.robot._dynamics.rows(own)  # noqa: SLF001 - a part of it
        names, shapes = ", ".join(own), {tuple(np.shape(each)) for each in own.values()}
        if len(places | shapes) > 2:
            raise InputError(list(own)[-1], f"{names} have to be all on the host, or all on the device with the same shape")
        shape = self.robot.tree.q_shape
        return next(iter(shapes))[:-1], {name: self._wide_rows(name, each, shape) for name, each in own.items()}

    def _mechanism(self, gravity: ArrayLike | None) -> tuple[Any, ...]:
        """The joints and the inertias of their bodies, on the device, and the acceleration of free fall."""
        dynamics = self.robot._dynamics  # noqa: SLF001 - a part of it
        joints, bodies = self._kept(("mechanism",), lambda: map(device.on_device, dynamics.mechanism))
        return joints, bodies, *dynamics.free_fall(gravity).tolist()

    def _sizes(self) -> tuple[int, int]:
        tree = self.robot.tree
        return tree.n_dof, len(tree.joints)
