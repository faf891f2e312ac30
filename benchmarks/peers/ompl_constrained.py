"""Runs OMPL's constrained spaces: RRT-Connect in C++ with a constraint and Ulna's checker from Python; counts all calls.

Source: Kingston, Moll and Kavraki, Exploring implicit spaces for constrained sampling-based planning (IJRR 2019). A constraint is
a function that must be 0, within a tolerance; a constraint with limits uses the excess over them. Edges are tested at samples.
"""

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric, util

import ulna
from benchmarks.constrained_problems import PLANE, TILT, TURN, ConstrainedProblem

Array = NDArray[np.float64]
SPACES = {"OMPL, projection": "Projected", "OMPL, atlas": "Atlas", "OMPL, tangent bundle": "TangentBundle"}
_SPARE = 0.9  # of a tolerance: the target of its functions


class Solved(NamedTuple):
    """A path, or None; its time [s]; the number of checked configurations, and of constraint evaluations."""

    path: Array | None
    seconds: float
    checks: int
    functions: int


class _Constraint(base.Constraint):
    """The functions of a problem that must be 0."""

    def __init__(self, robot: ulna.Robot, problem: ConstrainedProblem) -> None:
        sizes = {"upright": (1, 1e-3), "orientation": (3, _SPARE * TURN), "plane": (1, _SPARE * PLANE),
                 "line": (2, _SPARE * problem.away[0]), "box": (3, 1e-3)}  # fmt: skip
        super().__init__(robot.n_dof, *sizes[problem.kind])
        self._robot, self._problem, self.calls = robot, problem, 0

    def function(self, q, out) -> None:
        """Write the values."""
        self.calls += 1
        out[:] = self._values(self._robot.forward_kinematics(q, link=self._problem.link))[0]

    def jacobian(self, q, out) -> None:
        """Write their derivatives."""
        self.calls += 1
        problem = self._problem
        T, J = self._robot.forward_kinematics(q, link=problem.link), self._robot.jacobian(q, link=problem.link)
        out[:, :] = self._values(T)[1] @ J

    def _values(self, T: Array) -> tuple[Array, Array]:
        """The values, and their derivatives by a twist of the hand, shape (n, 6)."""
        problem, R = self._problem, self._problem.T[:3, :3]
        if problem.kind == "upright":
            z, aim = T[:3, 2], R[:, 2]
            excess = np.arccos(np.clip(z @ aim, -1.0, 1.0)) - _SPARE * TILT
            sine = max(np.linalg.norm(np.cross(z, aim)), 1e-9)
            return np.array([max(excess, 0.0)]), (excess > 0) * np.concatenate([np.zeros(3), -np.cross(z, aim) / sine])[None]
        if problem.kind == "orientation":
            x, y, z = (np.cross(T[:3, k], R[:, k]) for k in range(3))
            return -0.5 * (x + y + z), np.hstack([np.zeros((3, 3)), np.eye(3)])
        u, J = R.T @ (T[:3, 3] - problem.T[:3, 3]), np.hstack([R.T, np.zeros((3, 3))])
        if problem.kind == "box":
            over = np.sign(u) * np.maximum(np.abs(u) - np.array(problem.away) + 2e-3, 0.0)
            return over, (over != 0.0)[:, None] * J
        rows = [2] if problem.kind == "plane" else [0, 1]
        return u[rows], J[rows]


def solve(name: str, robot: ulna.Robot, problem: ConstrainedProblem, world: ulna.World, most: float) -> Solved:
    """Solve the problem in one of SPACES; the path contains the tested states."""
    util.noOutputHandler()
    util.RNG.setSeed(1)
    n, counted = robot.n_dof, [0]
    real, bounds = base.RealVectorStateSpace(n), base.RealVectorBounds(n)
    for j in range(n):
        bounds.setLow(j, float(max(robot.lower[j], -2 * np.pi)))
        bounds.setHigh(j, float(min(robot.upper[j], 2 * np.pi)))
    real.setBounds(bounds)
    constraint, q = _Constraint(robot, problem), np.empty(n)
    space = getattr(base, f"{SPACES[name]}StateSpace")(real, constraint)
    bundle = SPACES[name] == "TangentBundle"
    setup = geometric.SimpleSetup((base.TangentBundleSpaceInformation if bundle else base.ConstrainedSpaceInformation)(space))

    def is_free(state) -> bool:
        counted[0] += 1
        for j in range(n):
            q[j] = state[j]
        return not robot.in_collision(q, world)

    setup.setStateValidityChecker(is_free)
    ends = []
    for given in (problem.start, problem.goal):
        state = space.allocState()
        state.copy(np.array(given))
        if SPACES[name] != "Projected":
            try:
                space.anchorChart(state)
            except RuntimeError:  # a constraint with limits is no manifold within them
                return Solved(None, np.nan, 0, constraint.calls)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    setup.setup()
    began = time.thread_time()
    path = None
    if setup.solve(most) and setup.haveExactSolutionPath():
        found = setup.getSolutionPath()
        found.interpolate()
        path = np.array([[found.getState(k)[j] for j in range(n)] for k in range(found.getStateCount())])
    return Solved(path, time.thread_time() - began, counted[0], constraint.calls)
