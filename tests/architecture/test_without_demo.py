"""The demo is a guest: the library's tests pass without it. Here a part of every room; ``make test-without-demo`` runs all."""

import pytest

from without_demo import run_without_demo

SOME = (
    "tests/architecture",
    "tests/bench/test_timing.py",
    "tests/cli/test_command.py",
    "tests/cli/test_numbers.py",
    "tests/cli/test_check.py",
    "tests/cli/test_record.py",
    "tests/collision/test_scene_file.py",
    "tests/collision/test_self_collision.py",
    "tests/description/test_xacro.py",
    "tests/kinematics/test_tree.py",
    "tests/viewer/session/test_joints.py",
    "tests/viewer/test_palette.py",
    "tests/test_doc_pages.py::test_a_long_command_of_a_page_has_the_options_that_the_page_gives_it",
)
QUICK = "not slow and not matrix and not process"  # the others ask the same of the library with the demo


@pytest.mark.slow  # it is a run of tests within a run
@pytest.mark.compiler  # a copy of the sources has no machine code
@pytest.mark.timeout(900)  # on a machine that has compiled nothing yet
def test_the_tests_of_the_library_pass_without_the_demo():
    assert run_without_demo("-q", "-p", "no:cacheprovider", "-m", QUICK, *SOME).returncode == 0
