"""The resource limits of the child: never above the system's; a limit that cannot be set is skipped and named."""

import ctypes
import subprocess
import sys

import pytest

from ulna.description.xacro.child.confinement import LIMITS, set_limits
from ulna.description.xacro.expansion import _limits

resource = pytest.importorskip("resource", reason="limits of POSIX")

CAP_SYS_RESOURCE, DROP = 24, 24
LOAD = """
import ulna
print(ulna.load('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="${1 + 1}"/></robot>').link_names)
"""


class MacOS:
    """The module ``resource`` of macOS: it has the limit of address space, but refuses to set it."""

    RLIM_INFINITY = -1
    RLIMIT_AS, RLIMIT_CPU, RLIMIT_CORE, RLIMIT_FSIZE, RLIMIT_NOFILE = range(5)

    def __init__(self):
        self.set = {}

    def getrlimit(self, kind):
        return (0, 7) if kind == self.RLIMIT_CPU else (self.RLIM_INFINITY, self.RLIM_INFINITY)

    def setrlimit(self, kind, value):
        if kind == self.RLIMIT_AS:
            raise ValueError("current limit exceeds maximum limit")
        self.set[kind] = value


def test_a_limit_that_cannot_be_set_is_skipped_and_named():
    system = MacOS()
    left_out = set_limits(2 << 30, 20, system)
    assert left_out["RLIMIT_AS"] == "current limit exceeds maximum limit"
    assert "RLIMIT_NPROC" in left_out["RLIMIT_NPROC"]
    assert system.set[system.RLIMIT_NOFILE] == (0, 0)
    said = _limits(2 << 30, 20, left_out)
    assert said.startswith("its limits are 20 s; this system has not granted RLIMIT_AS (current limit exceeds maximum limit), ")


def test_a_lower_limit_of_the_system_is_kept():
    system = MacOS()
    set_limits(2 << 30, 20, system)
    assert system.set[system.RLIMIT_CPU] == (7, 7)


def test_without_the_module_resource_every_limit_is_skipped():
    assert set(set_limits(2 << 30, 20, None)) == set(LIMITS)


def as_an_ordinary_user():
    """Drop the right to raise limits, which root has."""
    ctypes.CDLL(None).prctl(DROP, CAP_SYS_RESOURCE, 0, 0, 0)


@pytest.mark.process
@pytest.mark.skipif(sys.platform != "linux", reason="the rights of root")
@pytest.mark.parametrize(("kind", "most"), [(resource.RLIMIT_AS, 1_900_000 * 1024), (resource.RLIMIT_CPU, 20)])
def test_a_document_is_expanded_under_lower_limits_of_the_system(kind, most):
    """As after ``ulimit -v 1900000`` or ``ulimit -t 20``."""

    def lower():
        resource.setrlimit(kind, (most, most))
        as_an_ordinary_user()

    done = subprocess.run([sys.executable, "-c", LOAD], preexec_fn=lower, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("('2',)\n", "")
