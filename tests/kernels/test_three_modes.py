"""One source, one answer: float64, eight lanes, and NumPy without the compiler."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import closed_form_probes
import kernel_cases
import kernel_modes
import kernel_probes
import ulna
from assertions import assert_close

TESTS = Path(kernel_cases.__file__).parent


@pytest.fixture(scope="module")
def without_compiler(tmp_path_factory):
    """The answers of a process of its own, for whether Numba compiles is settled when it is imported."""
    file = tmp_path_factory.mktemp("modes") / "answers.npz"
    paths = os.pathsep.join([str(TESTS), str(Path(ulna.__file__).parents[1])])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    subprocess.run([sys.executable, kernel_cases.__file__, str(file)], env=environment, check=True)
    with np.load(file) as answers:
        return dict(answers)


@pytest.fixture(scope="module")
def of_this_process():
    return kernel_cases.answers()


@pytest.mark.parametrize("name", kernel_cases.cases())
@pytest.mark.parametrize("mode", kernel_modes.MODES)
def test_this_process_agrees_with_plain_numpy(of_this_process, without_compiler, name, mode):
    here = of_this_process[f"{name}/{mode}"]
    for plain in ("scalars", "arrays"):
        assert_close(here, without_compiler[f"{name}/{plain}"], rtol=1e-13, atol=2e-14, equal_nan=True)


def test_every_probe_has_a_case():
    told_by_their_own_tests = {"any_of", "load_and_store"}  # what they do depends on the number of lanes, or is exact
    told_by_their_own_tests |= {"onto", "to_plane", "to_sphere", "to_direction", "arc_tangent", "vector_at"}  # test_subproblems
    told_by_their_own_tests |= {"pair_of_circles", "pair_of_lines"}  # test_two_circles
    modules = kernel_probes, closed_form_probes
    own = {name for m in modules for name, f in vars(m).items() if getattr(f, "__module__", "") == m.__name__}
    defined = {name for name in own if not name.startswith("_")}
    covered = {probe.__name__ for probe, *_ in kernel_cases.cases().values()}
    assert covered == defined - told_by_their_own_tests


def test_a_case_without_a_number_proves_nothing():
    for name, (_, inputs, _, _) in kernel_cases.cases().items():
        assert np.isfinite(inputs).all(), name
