"""Which joint positions bring a link to a pose."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.robot.structure import Structure

if TYPE_CHECKING:
    from ulna.ik.result import IKResult
    from ulna.ik.single_target import SingleTarget, SingleTargetKey
    from ulna.ik.task import Task

Array = NDArray[np.float64]
_MOST_KEPT = 64  # searches made ready


class InverseKinematics(Structure):
    """Searches for configurations, and steps of a control loop."""

    def inverse_kinematics(
        self,
        T: ArrayLike,
        q_seed: ArrayLike | None = None,
        link: str | None = None,
        method: str = "levenberg_marquardt",
        seed: int = 0,
        *,
        task: Task | str = "pose",
        world: World | None = None,
        rank: str | None = None,
        posture: ArrayLike | str | None = None,
        held: Iterable[str] = (),
        max_step: float | None = None,
        position_tolerance: float = 1e-5,
        rotation_tolerance: float = 1e-5,
        max_iterations: int | None = None,
        time_limit: float | None = None,
        threads: int | None = None,
        trace: bool = False,
    ) -> IKResult:
        """Joint positions that bring a link to a pose, within the joint limits.

        Args:
            T: The poses to reach, T_base_link, shape (..., 4, 4).
            q_seed: Where to start [rad or m], shape (..., n_dof) or (n_dof,). If given, its branch is followed as long as it
                leads to the target, and after that the solution nearest to it is taken; otherwise the search starts from
                ``home`` and random configurations.
            link: The link's name; the tip unless given.
            method: ``"levenberg_marquardt"``: many searches at once, with restarts; or, from the seed alone and for teaching,
                ``"jacobian_transpose"``, ``"pseudo_inverse"``, ``"damped_least_squares"``.
            seed: Chooses the random configurations; without ``time_limit`` the result depends on nothing else.
            task: ``"pose"``; ``"position"``: any orientation; ``"pointing"``: position and the direction of the link's z axis;
                or an ``ulna.Task`` (another axis, slack by component).
            world: Configurations that collide with it, or in which the robot touches itself, are rejected, and the search goes
                on.
            rank: Which of several solutions: ``"nearest"`` to the seed (largest joint change), ``"manipulability"``,
                ``"clearance"`` from the world, ``"mid_range"`` of the joints. It chooses among what sixteen starts find.
            posture: Of all solutions near the seed, the one nearest to this configuration, shape (n_dof,), or to
                ``"mid_range"``. The pose comes first: where limits stand in the way or the steps run out, the posture is met
                less well, or not.
            held: Names of joints that stay at the seed.
            max_step: The most that any entry of q may differ from ``q_seed`` [rad or m]: refused rather than passed.
            position_tolerance: Largest distance that counts as reached [m].
            rotation_tolerance: Largest angle that counts as reached [rad].
            max_iterations: Steps from all starts together before giving up; 16 000 (800 starts), or 10 000 for the others.
            time_limit: Seconds before giving up, looked at between rounds.
            threads: For large batches; all cores unless given. The result is the same bit for bit.
            trace: For one target: keep errors, step and damping of every step (``result.trace``).

        Returns:
            An ``IKResult``: q, success, status, errors, iterations, and the reasons. A target that is not reached is a result
            too.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> print(panda.inverse_kinematics(panda.forward_kinematics(panda.home) + 0.0).status)
            solved
        """
        plain = world is rank is posture is max_step is max_iterations is time_limit is threads is None and not trace
        plain = plain and type(position_tolerance) is type(rotation_tolerance) is float and type(seed) is int
        plain = plain and type(task) is str and type(held) is tuple and not held and (link is None or type(link) is str)
        if plain and task == "pose" and method == "levenberg_marquardt":
            key = link, position_tolerance, rotation_tolerance, seed
            quick = self._quick.get(key) or self._make_quick(key)
            result = quick.solve(T, q_seed)
            if result is not None:
                return result
        return self._search.inverse_kinematics(
            self.tree,
            T,
            self._the_tip if link is None else link,
            self.home,
            q_seed=q_seed,
            method=method,
            seed=seed,
            task=task,
            rank=rank,
            posture=posture,
            held=held,
            max_step=max_step,
            tolerances=(position_tolerance, rotation_tolerance),
            max_iterations=max_iterations,
            time_limit=time_limit,
            threads=threads,
            trace=trace,
            obstacles=None if world is None else self._obstacles(self, world),
            quick=lambda key: self._quick.get(key) or self._make_quick(key),
        )

    def inverse_kinematics_all(
        self,
        T: ArrayLike,
        q_seed: ArrayLike | None = None,
        link: str | None = None,
        seed: int = 0,
        *,
        task: Task | str = "pose",
        position_tolerance: float = 1e-5,
        rotation_tolerance: float = 1e-5,
        n_spread: int = 16,
    ) -> Array:
        """The distinct joint positions that bring a link to a pose, within the joint limits.

        Args:
            T: The pose to reach, T_base_link, shape (4, 4).
            q_seed: The solutions come nearest to this first [rad or m], shape (n_dof,); ``home`` unless given.
            link: The link's name; the tip unless given.
            seed: Chooses the random starts; the result depends on nothing else.
            task: What of the pose has to be met; see ``inverse_kinematics``.
            position_tolerance: Largest distance that counts as reached [m].
            rotation_tolerance: Largest angle that counts as reached [rad].
            n_spread: How many, well apart, are taken from a continuum of solutions.

        Returns:
            Shape (n, n_dof), n = 0 if none was found. For an arm with as many joints as the task asks components, every branch
            that the search met, each once, whole turns aside; for others a spread set.

        Example:
            >>> import ulna
            >>> planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
            >>> elbows = planar.inverse_kinematics_all(planar.forward_kinematics([0.3, 0.5]), task="position")
            >>> len(elbows)
            2
        """
        return self._search.inverse_kinematics_all(
            self.tree,
            T,
            self._the_tip if link is None else link,
            self.home,
            q_seed=q_seed,
            seed=seed,
            task=task,
            tolerances=(position_tolerance, rotation_tolerance),
            n_spread=n_spread,
        )

    def differential_ik(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        dt: float,
        link: str | None = None,
        expressed_in: str = "base",
        *,
        damping: float = 0.01,
        out: Array | None = None,
    ) -> Array:
        """The joint velocities that give a link a twist for one step, as well as velocity and position limits allow.

        They minimise |J qd - twist|^2 + damping^2 |qd|^2 within the limits: the only minimum, near singularities too, where the
        damping keeps them short.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            twist: v [m/s] and w [rad/s] of the link, shape (..., 6).
            dt: The step's length [s]: ``q + dt * qd`` lies within the position limits, to rounding.
            link: The link's name; the tip unless given.
            expressed_in: The frame of the twist; see ``jacobian``.
            damping: Above 0. Where the arm moves well a velocity is short by a share of about damping^2 / sigma^2, with sigma
                the smallest singular value of J; no joint moves faster than |twist| / (2 damping). A damping below 1e-4 |J| takes
                some times longer; singular values below 1e-14 |J| are within the rounding of J, and count as 0.
            out: Written to and returned if given: a float64 array of the result's shape.

        Returns:
            qd [rad/s or m/s], shape (..., n_dof).

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> qd = panda.differential_ik(panda.home, [0.1, 0, 0, 0, 0, 0], dt=0.001)
            >>> float((panda.jacobian(panda.home) @ qd)[0].round(3))
            0.1
        """
        link = self._the_tip if link is None else link
        return self._differential.differential_ik(self.tree, q, twist, dt, link, expressed_in, damping, out)

    # The layers below are imported when first used: they load the compiler, which `import ulna` must not.

    @cached_property
    def _search(self):
        from ulna.ik import search

        return search

    @cached_property
    def _differential(self):
        from ulna.ik import differential

        return differential

    @cached_property
    def _obstacles(self):
        from ulna.ik.collision_filter import Obstacles

        return Obstacles

    @cached_property
    def _quick(self) -> dict:
        return {}

    def _make_quick(self, key: SingleTargetKey) -> SingleTarget:
        """What stays the same from call to call of ``inverse_kinematics``, kept for the next."""
        from ulna.ik.single_target import SingleTarget

        link, position, rotation, seed = key
        if len(self._quick) >= _MOST_KEPT:
            self._quick.clear()
        quick = SingleTarget(self.tree, self._the_tip if link is None else link, self.home, (position, rotation), seed)
        return self._quick.setdefault(key, quick)
