"""Numbers the statuses of a map's poses, as its variable ``reached`` has them. Used by ``store`` and ``chunk``."""

import numpy as np

from ulna.ik.result import CODES, Status

NEVER = -1  # a pose that was not computed yet
REACHED = 1
NUMBERS = {
    Status.SOLVED: REACHED,
    Status.UNREACHABLE: 2,
    Status.BUDGET_SPENT: 3,
    Status.IN_COLLISION: 4,
    Status.JOINT_LIMITS: 5,
    Status.SINGULAR: 6,
    Status.STATIONARY: 7,
    Status.NOT_FOUND: 8,
    Status.BEYOND_MAX_STEP: 9,
    Status.HELD_JOINTS: 10,
}
OF_CODES = np.full(1 + max(CODES.values()), NUMBERS[Status.NOT_FOUND], dtype=np.int8)  # by the codes of the kernels
for _status, _code in CODES.items():
    OF_CODES[_code] = NUMBERS[_status]
