"""Declares the settings and results of IK searches as records (``engine/records.py``)."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record


class SearchSettings(Record):
    """The settings of a search, the same for all of its targets.

    Attributes:
        position_tolerance: The maximum distance that counts as reached [m].
        rotation_tolerance: The maximum angle that counts as reached [rad].
        steps: The maximum number of steps from one start.
        seeded_steps: The maximum from the first start; 0: ``steps``.
        calm: Whether the damping includes the size of the error. Such a search converges for unreachable targets.
        first_wins: Early end of a search for one target: 0 for none, ANY or NEAREST (``ik.entries.multi_start``).
        with_posture: Whether there is a posture.
        task: Components of the pose error that count: WHOLE_POSE, WITH_SLACK or POINTING, in the target's axes.
        slack: Tolerance of each component at no cost [m, rad], read unless the task is the WHOLE_POSE.
        max_square: The square of the distance [m^2] beyond which the damping grows no more; 0 for no such distance.
    """

    position_tolerance: float
    rotation_tolerance: float
    steps: int
    seeded_steps: int
    calm: bool
    first_wins: int
    with_posture: bool
    task: int
    slack: Annotated[NDArray[np.float64], 6]
    max_square: float


class SearchResult(Record):
    """The result for one target, or for one job of a search.

    Attributes:
        status: SOLVED, NOT_FOUND or NOT_A_POSE, or a code that only an explanation sets (``ik.result``).
        iterations: Steps from the start that led to the result.
        start: The number of that start.
        position_error: Distance of the configuration's pose from the target [m].
        rotation_error: Angle between them [rad].
        residual: The components of the error, in the target's axes [m, rad].
        residual_square: The squared residual of the task [m^2 + rad^2].
        damping: The damping of the last step.
    """

    status: int
    iterations: int
    start: int
    position_error: float
    rotation_error: float
    residual: Annotated[NDArray[np.float64], 6]
    residual_square: float
    damping: float


Results = NDArray[np.void]
"""An array of such records, of any shape."""
