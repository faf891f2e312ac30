"""How many processors a process may use: its affinity, and the quotas of control groups, in made-up file systems."""

import math
import os
import subprocess
import sys

import pytest

from ulna.engine import processors
from ulna.engine.processors import cpu_quota, n_processors

GROUPS = {
    "none": ({}, math.inf),
    "version 2": ({"proc/self/cgroup": "0::/job", "sys/fs/cgroup/job/cpu.max": "150000 100000"}, 1.5),
    "version 2, no limit": ({"proc/self/cgroup": "0::/job", "sys/fs/cgroup/job/cpu.max": "max 100000"}, math.inf),
    "version 2, a group above": (
        {"proc/self/cgroup": "0::/a/b/c", "sys/fs/cgroup/a/cpu.max": "50000 100000", "sys/fs/cgroup/a/b/c/cpu.max": "max 100000"},
        0.5,
    ),
    "version 2, the lower of two": (
        {"proc/self/cgroup": "0::/a/b", "sys/fs/cgroup/a/cpu.max": "300000 100000", "sys/fs/cgroup/a/b/cpu.max": "400000 100000"},
        3,
    ),
    "version 2 in a container": ({"proc/self/cgroup": "0::/", "sys/fs/cgroup/cpu.max": "200000 100000"}, 2),
    "version 2 in a container that sees the host's path": (
        {"proc/self/cgroup": "0::/docker/1", "sys/fs/cgroup/cpu.max": "200000 100000"},
        2,
    ),
    "version 1": (
        {
            "proc/self/cgroup": "4:memory:/job\n3:cpu,cpuacct:/job",
            "sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us": "250000",
            "sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us": "100000",
        },
        2.5,
    ),
    "version 1, no limit": (
        {
            "proc/self/cgroup": "3:cpu:/job",
            "sys/fs/cgroup/cpu/job/cpu.cfs_quota_us": "-1",
            "sys/fs/cgroup/cpu/job/cpu.cfs_period_us": "100000",
        },
        math.inf,
    ),
    "version 1 in a container": (
        {
            "proc/self/cgroup": "3:cpuacct,cpu:/docker/1",
            "sys/fs/cgroup/cpu/cpu.cfs_quota_us": "100000",
            "sys/fs/cgroup/cpu/cpu.cfs_period_us": "50000",
        },
        2,
    ),
    "both, the second for nothing": (
        {
            "proc/self/cgroup": "1:cpu:/job\n0::/job",
            "sys/fs/cgroup/cpu/job/cpu.cfs_quota_us": "300000",
            "sys/fs/cgroup/cpu/job/cpu.cfs_period_us": "100000",
            "sys/fs/cgroup/unified/job/cgroup.procs": "1",
        },
        3,
    ),
    "another name of a group": ({"proc/self/cgroup": "9:name=systemd:/job", "sys/fs/cgroup/job/cpu.max": "1 1"}, math.inf),
    "damaged": ({"proc/self/cgroup": "0::/job", "sys/fs/cgroup/job/cpu.max": "many"}, math.inf),
    "damaged list": ({"proc/self/cgroup": "nothing\n", "sys/fs/cgroup/cpu.max": "100000 100000"}, math.inf),
}


@pytest.mark.parametrize("name", GROUPS)
def test_the_quota_is_that_of_the_tightest_group(tmp_path, name):
    files, quota = GROUPS[name]
    for path, text in files.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text + "\n")
    assert cpu_quota(tmp_path) == quota


@pytest.mark.parametrize(("quota", "number"), [(0.2, 1), (1.5, 2), (3, 3), (math.inf, 4)])
def test_a_quota_bounds_the_number_and_a_part_counts_as_one(monkeypatch, quota, number):
    monkeypatch.setattr(processors, "cpu_quota", lambda _: quota)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 2, 4, 6}, raising=False)
    assert n_processors() == number


@pytest.mark.process
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no affinity")
def test_the_affinity_of_the_process_counts():
    code = """
import os
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from ulna.engine.threads import default_threads
print(default_threads())
"""
    environment = {name: value for name, value in os.environ.items() if name != "ULNA_THREADS"}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert run.stdout == "1\n"
