"""Finds the processors that this process may use, and the width of their vector instructions."""

import math
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from ulna.engine.ahead import is_ahead, level

_ROOT = Path("/")
# The names of wide registers in assembly, x86's and then ARM's, with their bits; the first match is the widest.
_REGISTERS = (("%zmm", 512), ("%ymm", 256), ("%xmm", 128), (".2d", 128))
_OF_LEVEL = {"x86-64-v3": 256, "x86-64-v4": 512}


def n_processors() -> int:
    """The number of processors that this process may use, at least 1.

    A container's or a service's quota (``docker run --cpus``, ``CPUQuota=``) counts too; a fraction of a processor is rounded up.
    """
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, math.ceil(min(allowed, cpu_quota(_ROOT))))


@cache
def register_bits() -> int | None:
    """The register width of an addition of lanes [bits], from its machine code or its level; None without either.

    It describes the compiled code, not the processor: ``NUMBA_CPU_NAME`` and the compiler's settings matter too.
    """
    if is_ahead():
        return _OF_LEVEL.get(level(), 128)
    import numpy as np  # noqa: PLC0415 - most callers need neither this nor the compiler

    from ulna.engine.decorators import routine  # noqa: PLC0415
    from ulna.engine.lanes import load, store  # noqa: PLC0415

    def double(rows):
        store(rows, 0, load(rows, 0) + load(rows, 0))

    compiled = routine(double)
    if not hasattr(compiled, "inspect_asm"):
        return None
    compiled(np.zeros((1, 8)))
    code = next(iter(compiled.inspect_asm().values()))
    return next((bits for name, bits in _REGISTERS if name in code), None)


def cpu_quota(root: Path) -> float:
    """The minimum CPU quota of this process's control groups and their parents [processors]; infinite without one.

    Version 2 has "quota period" in ``cpu.max``, version 1 two files ``cpu.cfs_quota_us`` and ``cpu.cfs_period_us``. Source: the
    kernel's documentation, admin-guide/cgroup-v2 and scheduler/sched-bwc. In a container a group may be at the root of the
    mounted tree, whatever the process's path, so the root is read as well.

    Args:
        root: The root of the file system; another one for tests.
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
    """The text of a file; empty if it is missing or unreadable."""
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
