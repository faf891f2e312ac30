"""With ULNA_NO_SKIPS=1, as in CI, a test that is skipped has failed: nothing is left out in silence."""

import os
from importlib.util import find_spec

import pytest

# They import ROS, of which no environment has both: tests/demo/ros runs them where it is.
collect_ignore_glob = [f"src/ulna/demo/ros/{name}.py" for name in ("messages", "ros[12]*", "rviz_video", "servo_node")]
# They import a library that is in an environment of its own: make test-learning.
for library, file in (("torch", "tensors"), ("jax", "callbacks")):
    if find_spec(library) is None:
        collect_ignore_glob += [f"src/ulna/{library}.py", f"src/ulna/learning/{file}.py"]


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """Turn a skipped test into a failed one."""
    outcome = yield
    report = outcome.get_result()
    if report.skipped and not hasattr(report, "wasxfail") and os.environ.get("ULNA_NO_SKIPS"):
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid}: skipped, but ULNA_NO_SKIPS is set: {call.excinfo.value if call.excinfo else ''}"


def pytest_terminal_summary(terminalreporter):
    """Say how long the tests took, all workers together: the budget of ``make test``, which no test asserts."""
    reports = [report for some in terminalreporter.stats.values() for report in some]
    seconds = sum(getattr(report, "duration", 0.0) for report in reports)
    terminalreporter.write_line(f"{seconds:.0f} worker seconds in the tests; the budget of make test is 480, on an idle machine")


def pytest_collectreport(report):
    """Turn a skipped module into a failed one."""
    if report.skipped and os.environ.get("ULNA_NO_SKIPS"):
        report.outcome = "failed"


def pytest_ignore_collect(collection_path):
    """Leave out a module of tests about the compiler where there is none: it imports it."""
    if find_spec("numba") is not None or collection_path.suffix != ".py":
        return None
    return "\npytestmark = pytest.mark.compiler\n" in collection_path.read_text(encoding="utf-8") or None
