"""One source, one answer: float64, eight lanes, and NumPy without the compiler.

Run as a program, it writes this process's answers: NUMBA_DISABLE_JIT=1 python test_three_modes.py answers.npz
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import closed_form_probes
import formulas
import kernel_modes
import kernel_probes as probes
import robots
import ulna
from assertions import assert_close
from ulna.dh.from_table import description_from_dh
from ulna.ik.closed_form.closed_form import closed_form_of, joints_at
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.ik.levenberg_marquardt import N_STATE
from ulna.kernels.ik.search_layout import N_SYSTEM, POINTING, WHOLE_POSE, WITH_SLACK
from ulna.kernels.ik.search_records import SearchSettings
from ulna.kernels.layout import BODY_WIDTH, BOX, HULL, N_VERTICES, SHAPE
from ulna.kinematics.tree import build_tree

TESTS = Path(probes.__file__).parent
N = 24
TREE = build_tree(robots.every_joint())
CHAIN = TREE.chain("fingertip")
N_DOF, N_JOINTS, N_LINKS = TREE.n_dof, len(TREE.joints), len(TREE.link_names)
BODIES = np.arange(2 * BODY_WIDTH).reshape(2, BODY_WIDTH) / 10.0
BODIES[1, [SHAPE, N_VERTICES - 1, N_VERTICES]] = HULL, 2, 3
WEDGE = np.array([(0, 0, 0), (0.7, 0, 0.1), (0, 0.8, 0), (0.1, 0.2, 0.9), (0.4, 0.3, -0.5)])
BOUNDS = np.concatenate([np.full(N_DOF, -1.0), np.full(N_DOF, 1.0)])[:, None].repeat(N, axis=1)
HALVES = np.full(N_DOF, 0.5)
N_ADVANCE = 2 * N_DOF + N_STATE + 6 * len(CHAIN) + 6 * N_DOF + N_SYSTEM


def cases():
    """(probe, inputs, number of outputs, tables) by name."""
    rng = np.random.default_rng(7)
    plain, angles = rng.normal(size=(2, N)), rng.uniform(-20, 20, (1, N))
    poses = np.array([random_pose(rng) for _ in range(2 * N)]).reshape(N, 24).T
    rotations = poses.reshape(2, 3, 4, N)[0, :, :3].reshape(9, N)
    q = rng.uniform(-1.5, 1.5, (N_DOF, N))
    J, e = rng.normal(size=(6 * N_DOF, N)), rng.normal(size=(6, N))
    system = np.vstack([J, np.full(N, 0.1), e])
    halves = rng.uniform(0.3, 1.5, (6, N))
    bodies = np.vstack([poses[:12], halves[:3], halves[:1] * 0.1, poses[12:], halves[3:], halves[:1] * 0.0])
    return {
        "arithmetic": (probes.arithmetic, plain, 16, ()),
        "comparisons": (probes.comparisons, plain, 12, ()),
        "logic": (probes.logic, plain, 5, ()),
        "choices": (probes.choices, abs(plain), 9, ()),
        "sine and cosine": (probes.sine_and_cosine, angles, 2, ()),
        "angle in the first quadrant": (probes.angle_in_first_quadrant, abs(plain), 1, ()),
        "vector of a rotation": (probes.vector_of_rotation, rotations, 3, ()),
        "vector between": (probes.vector_between, poses, 3, ()),
        "product": (probes.product, poses, 12, ()),
        "turn and slide": (probes.turn_and_slide, np.vstack([poses[:12], angles]), 24, ()),
        "constant": (probes.constant, plain[:1], 12, (CHAIN,)),
        "end of a chain": (probes.end_of_chain, q, 12, (CHAIN,)),
        "end of a chain by turns": (probes.end_of_chain_by_turns, q, 12 + 2 * len(CHAIN), (CHAIN,)),
        "frames of a tree": (probes.frames_of_tree, q, 12 * (N_JOINTS + N_LINKS), (TREE.joints, TREE.link_frames)),
        "jacobian": (probes.jacobian_of_chain, q, 6 * N_DOF + 12 + 6 * len(CHAIN), (CHAIN, 1, N_DOF)),
        "damped system": (probes.damped_system, system, 27, (N_DOF,)),
        "advance": (probes.one_advance, np.vstack([q, poses[:12], BOUNDS]), N_ADVANCE, (CHAIN, np.zeros(N_DOF), settings())),
        "posture": (probes.one_advance, np.vstack([q, poses[:12], BOUNDS]), N_ADVANCE, (CHAIN, HALVES, settings(posture=True))),
        "free columns": (probes.columns_that_are_free, np.vstack([J, e, q, BOUNDS]), 6 * N_DOF, (N_DOF,)),
        "slack": (probes.error_of_task, np.vstack([poses, e, J]), 6 + 6 * N_DOF, (settings(WITH_SLACK, 0.5), N_DOF)),
        "pointing": (probes.error_of_task, np.vstack([poses, e, J]), 6 + 6 * N_DOF, (settings(POINTING, np.inf), N_DOF)),
        "swing": (probes.swing_of_axes, poses, 3, ()),
        "two bodies": (probes.two_bodies, bodies, 11, (HULL, WEDGE, BOX, WEDGE[:0], tuple(map(np.zeros, SCRATCH)))),
        "row of bodies": (probes.row_of_bodies, poses[:12], 7, (BODIES, WEDGE)),
        "branch of a closed form": (closed_form_probes.one_branch, branch_inputs(poses[:12]), 9, (closed_form_table(),)),
        "branches of a closed form": (
            closed_form_probes.eight_branches,
            branch_inputs(poses[:12])[[*range(12), *range(15, 27)]],
            72 + 6,
            (closed_form_table(),),
        ),
        "branch of an arm that slides": (closed_form_probes.one_branch, branch_inputs(poses[:12]), 9, (sliding_table(),)),
        "single lanes": (probes.single_lanes, plain[:1], 2, ()),
        "two boxes": (probes.two_boxes, np.vstack([poses[:12], halves[:3], poses[12:], halves[3:]]), 3, ()),
    }


def closed_form_table():
    """Of a UR5."""
    tree = build_tree(description_from_dh(robots.UR5, convention="standard"))
    return joints_at(closed_form_of(tree, tree.tip), np.zeros(6)).table


def sliding_table():
    """Of a Stanford arm: axes 1 and 2 intersect, joint 3 slides."""
    rows = [(0, 0.4, -np.pi / 2, 0), (0, 0.15, np.pi / 2, 0), (0, 0, 0, 0)]
    wrist = [(0, 0, -np.pi / 2, 0), (0, 0, np.pi / 2, 0), (0, 0.1, 0, 0)]
    kinds = ["revolute"] * 2 + ["prismatic"] + ["revolute"] * 3
    tree = build_tree(description_from_dh(rows + wrist, joint_types=kinds, convention="standard"))
    return joints_at(closed_form_of(tree, tree.tip), np.zeros(6)).table


def branch_inputs(poses):
    """Poses, three signs, and twelve sines and cosines of undetermined angles."""
    signs = np.array([(-1.0) ** (np.arange(N) >> k) for k in range(3)])
    return np.vstack([poses * 0.4, signs, np.zeros((6, N)), np.ones((6, N))])


def settings(task=WHOLE_POSE, about_z=0.0, posture=False):
    """Of a search whose target is never met."""
    records = SearchSettings.records()
    records[0].task, records[0].slack[5], records[0].with_posture = task, about_z, posture
    return records


def random_pose(rng):
    return formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.normal(size=3))[:3].ravel()


def answers():
    """The outputs of every case in every mode of this process, by "case/mode"."""
    return {
        f"{name}/{mode}": kernel_modes.run(mode, probe, inputs, n_outputs, *tables)
        for name, (probe, inputs, n_outputs, tables) in cases().items()
        for mode in kernel_modes.MODES
    }


@pytest.fixture(scope="module")
def without_compiler(tmp_path_factory):
    """The answers of a process of its own, for whether Numba compiles is settled when it is imported."""
    file = tmp_path_factory.mktemp("modes") / "answers.npz"
    paths = os.pathsep.join([str(TESTS), str(Path(ulna.__file__).parents[1])])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    subprocess.run([sys.executable, __file__, str(file)], env=environment, check=True)
    with np.load(file) as answers:
        return dict(answers)


@pytest.fixture(scope="module")
def of_this_process():
    return answers()


@pytest.mark.process
@pytest.mark.parametrize("name", cases())
@pytest.mark.parametrize("mode", kernel_modes.MODES)
def test_this_process_agrees_with_plain_numpy(of_this_process, without_compiler, name, mode):
    here = of_this_process[f"{name}/{mode}"]
    for plain in ("scalars", "arrays"):
        assert_close(here, without_compiler[f"{name}/{plain}"], rtol=1e-13, atol=2e-14, equal_nan=True)


def test_every_probe_has_a_case():
    told_by_their_own_tests = {"any_of", "load_and_store"}  # what they do depends on the number of lanes, or is exact
    told_by_their_own_tests |= {"onto", "to_plane", "to_sphere", "to_direction", "arc_tangent", "vector_at"}  # test_subproblems
    told_by_their_own_tests |= {"pair_of_circles", "pair_of_lines"}  # test_two_circles
    modules = probes, closed_form_probes
    own = {name for m in modules for name, f in vars(m).items() if getattr(f, "__module__", "") == m.__name__}
    defined = {name for name in own if not name.startswith("_")}
    covered = {probe.__name__ for probe, *_ in cases().values()}
    assert covered == defined - told_by_their_own_tests


def test_a_case_without_a_number_proves_nothing():
    for name, (_, inputs, _, _) in cases().items():
        assert np.isfinite(inputs).all(), name


if __name__ == "__main__":
    np.savez(sys.argv[1], **answers())
