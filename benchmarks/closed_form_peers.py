"""Compares closed forms of other libraries with Ulna's, in one run: times, missed branches, errors.

Every branch of every target of a sample is compared. A library misses a branch that only the other library returns, and that
reaches the target by Ulna's forward kinematics. EAIK, ssik and jaik are timed if they are installed. The table names the missing
ones, and the reason why a library does not support an arm.
"""

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.ik_branches import distinct

Array = NDArray[np.float64]
_REPEATS, _MANY, _FEW, _COMPARED = 15, 2048, 64, 300
_REACHED, _APART = 1e-6, 1e-3
HEAD = f"\n| arm | library | batch | one call | only Ulna's | only the library's | largest error |\n|{'---|' * 7}\n"
_JAIK = {"UR5": "ur5", "UR5e": "ur5e", "UR10": "ur10", "UR10e": "ur10e", "UR3": "ur3"}


@dataclass(frozen=True)
class Library:
    """All branches by one library for one arm.

    Attributes:
        name: The name of the library and of the call.
        one: Maps a target (4, 4) to branches (k, 6).
        many: Called with targets (n, 4, 4), for its time; None without a batch.
        call: Like ``one``, for its time: the call of a user.
    """

    name: str
    one: Callable[[Array], Array]
    call: Callable[[Array], object]
    many: Callable[[Array], object] | None = None


def of_ulna(robot: ulna.Robot) -> Library:
    """Ulna's own."""

    def one(T: Array) -> Array:
        found = robot.all_solutions(T)
        return found.q[found.real]

    def many(T: Array) -> object:
        with ulna.threads(1):
            return robot.all_solutions(T)

    return Library("Ulna", one, robot.all_solutions, many)


def eaik_of(robot: ulna.Robot):
    """The same axes for EAIK; None if it is not installed."""
    try:
        from eaik.pybindings import EAIK  # noqa: PLC0415 - optional
    except ImportError:
        return None
    T = robot.forward_kinematics(np.zeros(6))
    J = robot.jacobian(np.zeros(6), expressed_in="base")
    w = J[3:].T
    o = T[:3, 3] - np.cross(J[:3].T, w)
    return EAIK.Robot(w.T, np.column_stack([o[0], *np.diff(o, axis=0), T[:3, 3] - o[-1]]), T[:3, :3], [], True)  # noqa: FBT003


def of_eaik(robot: ulna.Robot) -> Library:
    """EAIK.

    Raises:
        ImportError: It is not installed.
    """
    arm = eaik_of(robot)
    if arm is None:
        raise ImportError("eaik")

    def one(T: Array) -> Array:
        return np.atleast_2d(arm.calculate_IK(T).Q).reshape(-1, 6)

    return Library("EAIK", one, arm.calculate_IK, lambda T: arm.calculate_IK_batched(list(T), 1))


def of_ssik(robot: ulna.Robot) -> Library:
    """ssik, specialized for the same URDF; it has no batch."""
    from benchmarks.peer import standing_offset  # noqa: PLC0415
    from benchmarks.peers.ssik import build  # noqa: PLC0415 - optional

    arm = build(robot)
    offset = standing_offset(robot, arm.fk)

    def one(T: Array) -> Array:
        return np.array([found.q for found in arm.solve(T @ offset)]).reshape(-1, 6)

    return Library("ssik", one, lambda T: arm.solve(T @ offset))


def of_jaik(robot: ulna.Robot) -> Library:
    """jaik's form of Universal Robots' arms, by JAX: a batch is ``vmap``, compiled, in one thread.

    Raises:
        LookupError: It has no form of this arm, or of another geometry.
    """
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
    import jax  # noqa: PLC0415 - optional

    jax.config.update("jax_enable_x64", True)  # noqa: FBT003
    from jaik import make_robot  # noqa: PLC0415

    if robot.description.name not in _JAIK:
        raise LookupError("for Universal Robots' arms, Panda and a few others")
    forward, every, *_ = make_robot(_JAIK[robot.description.name], format="T")
    q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])
    if np.abs(np.asarray(forward(q)) - robot.forward_kinematics(q)).max() > _REACHED:
        raise LookupError("its geometry of this arm is another")
    single, batch = jax.jit(every), jax.jit(jax.vmap(every))

    def one(T: Array) -> Array:
        found, ok = single(T)[:2]
        return np.asarray(found).T[np.asarray(ok).astype(bool)]

    return Library("jaik", one, lambda T: single(T)[0].block_until_ready(), lambda T: batch(T)[0].block_until_ready())


LIBRARIES = {"EAIK": of_eaik, "ssik": of_ssik, "jaik": of_jaik}


def libraries(robot: ulna.Robot) -> Iterator[Library | tuple[str, str]]:
    """Ulna, then each other library, or its name and the reason for its absence."""
    yield of_ulna(robot)
    for name, make in LIBRARIES.items():
        try:
            yield make(robot)
        except ImportError:
            yield name, "not installed"
        except LookupError as error:
            yield name, str(error)


def compared(robot: ulna.Robot, theirs: Library, targets: Array) -> tuple[int, int, float]:
    """The number of Ulna's branches that a library misses, the reverse, and the library's largest error."""
    lacking, lacked, worst = 0, 0, 0.0
    for T in targets:
        found, own = theirs.one(T), robot.all_solutions(T)
        off = np.abs(robot.forward_kinematics(found) - T).max(axis=(1, 2)) if len(found) else np.empty(0)
        good, known = found[off < _REACHED], np.array(distinct(list(own.q[own.real])))
        worst = max(worst, float(off.max(initial=0.0)))
        lacking += sum(not _among(q, good) for q in known)
        lacked += sum(not _among(q, known) for q in good)
    return lacking, lacked, worst


def _among(q: Array, others: Array) -> bool:
    return len(others) > 0 and bool((np.abs((others - q + np.pi) % (2 * np.pi) - np.pi).max(axis=-1) < _APART).any())


def _nanoseconds(work: Callable[[], object], n: int) -> float:
    begin = time.process_time_ns()
    work()
    return (time.process_time_ns() - begin) / n


def peer_table(robot: ulna.Robot, name: str) -> Iterator[str]:
    """A row for each library: CPU time of the process, medians of interleaved turns."""
    rng = np.random.default_rng(2)
    T = robot.forward_kinematics(rng.uniform(-np.pi, np.pi, (_MANY, 6)))
    some, found = [T[i] for i in range(_FEW)], list(libraries(robot))
    works: dict[tuple[str, str], tuple[Callable[[], object], int]] = {}
    for library in found:
        if isinstance(library, Library):
            if library.many is not None:
                works[library.name, "many"] = (lambda many=library.many: many(T)), _MANY
            works[library.name, "one"] = (lambda call=library.call: [call(x) for x in some]), _FEW
    for work, _ in works.values():
        work()
    times = {key: [] for key in works}
    for _ in range(_REPEATS):
        for key, work in works.items():
            times[key].append(_nanoseconds(*work))
    middle = {key: float(np.median(of_it)) for key, of_it in times.items()}
    for library in found:
        if not isinstance(library, Library):
            yield f"| {name} | {library[0]} | {library[1]} | | | | |"
            continue
        lacking, lacked, worst = compared(robot, library, T[:_COMPARED])
        many = f"{middle[library.name, 'many']:,.0f} ns" if (library.name, "many") in middle else "-"
        one = f"{middle[library.name, 'one']:,.0f} ns"
        yield f"| {name} | {library.name} | {many} | {one} | {lacking} | {lacked} | {worst:.0e} |"
