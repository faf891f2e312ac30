"""Runs OMPL: RRT-Connect and its path simplifier in C++, with Ulna's checker called from Python for each configuration.

Source: Sucan, Moll and Kavraki, The Open Motion Planning Library (IEEE Robotics and Automation Magazine, 2012). Its Python
bindings accept no test of whole edges, so edges are tested at samples.
"""

import time

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric, util

import ulna
from benchmarks.vamp_problems import PlanningProblem
from ulna.planning.entries.search_records import RANGE, SAMPLES_APART

Way = tuple[NDArray | None, float]
MAX = 10.0  # s


class Planner:
    """OMPL's planner for a robot, with Ulna's checker."""

    def __init__(self, robot: ulna.Robot) -> None:
        util.noOutputHandler()
        self._robot, n = robot, robot.n_dof
        self._space, bounds = base.RealVectorStateSpace(n), base.RealVectorBounds(n)
        for j in range(n):
            bounds.setLow(j, float(max(robot.lower[j], -2 * np.pi)))
            bounds.setHigh(j, float(min(robot.upper[j], 2 * np.pi)))
        self._space.setBounds(bounds)
        self._space.setLongestValidSegmentFraction(SAMPLES_APART / self._space.getMaximumExtent())

    def solve(self, problem: PlanningProblem, world: ulna.World) -> tuple[Way, Way]:
        """The path and the simplified one, and their times [s]; the same samples for each problem."""
        util.RNG.setSeed(1)
        began = time.thread_time()
        setup = geometric.SimpleSetup(self._space)
        q, n, free_of = np.empty(self._robot.n_dof), self._robot.n_dof, self._robot.in_collision

        def is_free(state) -> bool:
            for j in range(n):
                q[j] = state[j]
            return not free_of(q, world)

        setup.setStateValidityChecker(is_free)
        planner = geometric.RRTConnect(setup.getSpaceInformation())
        planner.setRange(RANGE)
        setup.setPlanner(planner)
        setup.setStartAndGoalStates(self._state(problem.start), self._state(problem.goal))
        if not setup.solve(MAX) or not setup.haveExactSolutionPath():
            return (None, np.nan), (None, np.nan)
        planned, first = time.thread_time(), self._path(setup.getSolutionPath())
        again = time.thread_time()
        setup.simplifySolution()
        return (first, planned - began), (self._path(setup.getSolutionPath()), planned - began + time.thread_time() - again)

    def _path(self, path) -> NDArray:
        states = (path.getState(k) for k in range(path.getStateCount()))
        return np.array([[state[j] for j in range(self._robot.n_dof)] for state in states])

    def _state(self, q: NDArray):
        state = self._space.allocState()
        for j, value in enumerate(q):
            state[j] = float(value)
        return state
