"""How many processors this process may use: by its affinity, and by the CPU quota of its control groups."""

import math
import os
from collections.abc import Iterator
from pathlib import Path

_ROOT = Path("/")


def n_processors() -> int:
    """How many processors this process may use, at least 1.

    A container's or a service's quota (``docker run --cpus``, ``CPUQuota=``) counts too; a part of a processor is rounded up.
    """
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, math.ceil(min(allowed, cpu_quota(_ROOT))))


def cpu_quota(root: Path) -> float:
    """The least CPU quota of this process's control groups and of those above them [processors]; infinite if there is none.

    Version 2 has "quota period" in ``cpu.max``, version 1 two files ``cpu.cfs_quota_us`` and ``cpu.cfs_period_us``. Source: the
    kernel's documentation, admin-guide/cgroup-v2 and scheduler/sched-bwc. In a container a group may lie at the root of the
    mounted tree, whatever path the process is given, so that is read as well.

    Args:
        root: Of the file system; another one for tests.
    """
    quotas = [_quota_of(folder) for folder in _groups(root)]
    return min(quotas, default=math.inf)


def _groups(root: Path) -> Iterator[Path]:
    """The folders of this process's control groups that may limit its processors, and of the groups above each."""
    mounted = root / "sys/fs/cgroup"
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, _, rest = line.partition(":")  # of "hierarchy:controllers:path"
        controllers, colon, path = rest.partition(":")
        if not colon:
            continue
        if not controllers:
            homes = [mounted, mounted / "unified"]
        elif "cpu" in controllers.split(","):
            homes = [mounted / controllers, mounted / "cpu"]
        else:
            continue
        for home in homes:
            group = home / path.lstrip("/")
            yield from (folder for folder in (group, *group.parents) if folder.is_relative_to(home))


def _quota_of(folder: Path) -> float:
    """The quota of one group [processors]; infinite if it has none."""
    pair = _text(folder / "cpu.max").split()
    pair = pair or [*_text(folder / "cpu.cfs_quota_us").split(), *_text(folder / "cpu.cfs_period_us").split()]
    try:
        quota, period = map(float, pair)
    except ValueError:  # "max", or no such files
        return math.inf
    return quota / period if quota > 0 and period > 0 else math.inf


def _text(file: Path) -> str:
    """The text of a file; empty where there is none, or none that may be read."""
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
