"""Runs Levenberg-Marquardt from several starts per target, eight at a time.

A *job* is one start for one target. Jobs are numbered target by target. A lane takes the next job as soon as its own has ended,
so a hard target never delays the other lanes. Lanes are independent: the result of a job has the same bits for any jobs in the
other lanes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import entry, kernel, routine, workspace
from ulna.engine.lanes import WIDTH, any_lane, load
from ulna.engine.signatures import INDICES, MATRICES, MATRIX, NUMBERS, TABLE, Array, Group
from ulna.ik.entries.lane_state import reset_state, search_state, write_bounds, write_result, write_start, write_target
from ulna.kernels.ik.levenberg_marquardt import ENDED, HAS_SOLVED, P2, R2, RUNNING, advance
from ulna.kernels.ik.search_layout import NEAREST, NOT_A_POSE, SOLVED
from ulna.kernels.ik.search_records import SearchResult, SearchSettings
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect

_PATIENCE = 15  # steps of the seed's job
_WORTH_WAITING = 0.9  # of its squared error


class Jobs(NamedTuple):
    """The targets of a search and the starts of each.

    Attributes:
        targets: Poses, shape (n, 4, 4).
        order: The indices of the targets to search for, shape (m,).
        seeds: The seeds, shape (n or 1, n_dof).
        bounds: Bounds of q, and the range of starts (``lane_state``), shape (n or 1, 4, n_dof).
        samples: The starts as shares of the way from LOW to HIGH, NaN for the seed's own entry, shape (n_starts, n_dof).
        posture: The preferred configuration, shape (n_dof,); read if the settings enable it.
    """

    targets: NDArray[np.float64]
    order: NDArray[np.int64]
    seeds: NDArray[np.float64]
    bounds: NDArray[np.float64]
    samples: NDArray[np.float64]
    posture: NDArray[np.float64]


_SETTINGS, _RESULTS = Array(SearchSettings, 1, constant=True), Array(SearchResult, 1)
_JOBS = Group((MATRICES, INDICES, MATRIX, MATRICES, MATRIX, NUMBERS), Jobs)


@entry((TABLE, _SETTINGS, _JOBS, MATRIX, _RESULTS))
def search_jobs(chain, settings, jobs, q_out, info):
    """Search for each target of the order from every start.

    settings: One record. q_out: (m n_starts, n_dof) and info: (m n_starts,), one row a job. With ``first_wins`` the order holds
    one target, and row 0 is the result, or the nearest job. ANY: the first solved job ends the search. NEAREST: the first job is
    that of the seed, and its solution ends the search. If that job fails, or hardly advances while others have solutions, the
    solution nearest to the seed is taken. If there is none yet, the next one is taken.
    """
    run_jobs(chain, settings[0], jobs, q_out, info)


@entry((TABLE, _SETTINGS, NUMBERS, MATRIX, NUMBERS, MATRIX, _RESULTS))
def search_one(chain, settings, plan, target, seed, q_out, info):
    """Search for one target (4, 4) from one seed (n_dof,) and samples; whether it is solved.

    It has few arguments, since each costs some 50 ns. settings: One record. plan: The bounds (4 n_dof numbers), the posture and
    the samples, concatenated. q_out: (1, n_dof). info: One record.
    """
    n_dof, order = q_out.shape[1], np.zeros(1, dtype=np.int64)
    bounds, posture, samples = plan[: 4 * n_dof], plan[4 * n_dof : 5 * n_dof], plan[5 * n_dof :]
    jobs = Jobs(
        target.reshape((1, 4, 4)), order, seed.reshape((1, n_dof)), bounds.reshape((1, 4, n_dof)),
        samples.reshape((samples.shape[0] // n_dof, n_dof)), posture,
    )  # fmt: skip
    run_jobs(chain, settings[0], jobs, q_out, info)
    return info[0].status == SOLVED


@workspace
def run_jobs(chain, settings, jobs, q_out, info):
    """Keep the lanes busy until no job is left."""
    n_dof, n_starts = q_out.shape[1], jobs.samples.shape[0]
    rows, scratch = search_state(n_dof)
    own = np.full(WIDTH, -1)  # the job of each lane
    first_wins, found, best = settings.first_wins != 0, False, np.inf
    waiting, nearest = settings.first_wins == NEAREST, np.inf  # for the seed's job; and the distance of other jobs' solutions
    following, running, steps, before = 0, 0, 0, np.inf
    for lane in range(WIDTH):
        own[lane], following = start_job(settings, jobs, following, lane, rows, info)
        running += own[lane] >= 0
    while running > 0 and not found:
        advance(chain, jobs.posture, settings, rows, scratch)
        steps += 1
        if waiting and steps % _PATIENCE == 0:
            missed = rows[4][P2, 0] + rows[4][R2, 0]  # the seed's job stays in the first lane
            found, before = nearest < np.inf and missed > _WORTH_WAITING * before, missed
        if found or not any_lane(load(rows[4], ENDED) > RUNNING):
            continue
        for lane in range(WIDTH):
            if own[lane] < 0 or rows[4][ENDED, lane] == RUNNING:
                continue
            solved = first_wins and rows[4][ENDED, lane] == HAS_SOLVED
            missed = rows[4][P2, lane] + rows[4][R2, lane]
            if waiting and solved and own[lane] > 0:
                away = distance(rows[1], lane, jobs.seeds[min(jobs.order[0], jobs.seeds.shape[0] - 1)])
                better, nearest, best = away < nearest, min(away, nearest), 0.0
            else:
                better = solved or not first_wins or missed < best
                found = solved or (nearest < np.inf and own[lane] == 0)
                waiting, best = waiting and own[lane] > 0, min(best, missed)
            if better:
                row = 0 if first_wins else own[lane]
                write_result((rows[1], rows[2], rows[4]), lane, own[lane] % n_starts, row, q_out, info)
            if found:
                break
            own[lane], following = start_job(settings, jobs, following, lane, rows, info)
            running -= own[lane] < 0


@kernel
def distance(q_rows, lane, seed):
    """The largest difference of an entry of q in a lane from the seed."""
    largest = 0.0
    for j in range(seed.shape[0]):
        largest = max(largest, abs(q_rows[j, lane] - seed[j]))
    return largest


@routine
def start_job(settings, jobs, job, lane, rows, info):
    """Start the first valid job from ``job`` on in a lane; its number or -1, and the next number.

    A target that is no pose, or whose seed is out of range, gets this status in the information and is skipped.
    """
    n_starts = jobs.samples.shape[0]
    while job < jobs.order.shape[0] * n_starts:
        i, start = jobs.order[job // n_starts], job % n_starts
        seed = jobs.seeds[min(i, jobs.seeds.shape[0] - 1)]
        if start == 0 and not (rigidity_defect(jobs.targets[i]) <= LARGEST_DEFECT and all_in_range(seed)):
            for row in range(1 if settings.first_wins != 0 else n_starts):
                info[job + row].status = NOT_A_POSE
            job += n_starts
        else:
            write_target(matrix_pose(jobs.targets[i]), rows[2], lane)
            box = jobs.bounds[min(i, jobs.bounds.shape[0] - 1)]
            write_bounds(box, rows[3], lane)
            write_start(box, seed, jobs.samples, start, rows[0], lane)
            steps = settings.seeded_steps if start == 0 and settings.seeded_steps > 0 else settings.steps
            reset_state(rows[4], steps, settings.with_posture, lane)
            return job, job + 1
    return -1, job
