"""Names the machine and the versions that figures belong to; no host names, no paths."""

import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ulna.engine.ahead import is_ahead, level
from ulna.engine.processors import n_processors

PACKAGES = ("numpy", "numba", "llvmlite")


def machine_facts() -> dict[str, object]:
    """The processor, the cores that may be used, the kernels' widest register and where their code is from, and the versions."""
    from ulna.engine.processors import register_bits  # noqa: PLC0415 -- it loads the compiler, which other commands may not need

    return {
        "processor": processor_name(),
        "cores": n_processors(),
        "register_bits": register_bits(),
        "machine_code": f"ahead ({level()})" if is_ahead() else "compiled here",
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "ulna": installed_version("ulna"),
        **{name: installed_version(name) for name in PACKAGES},
    }


def installed_version(name: str) -> str:
    """The version of an installed package, or "absent"."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def processor_name() -> str:
    """The processor's name: on Linux as /proc/cpuinfo has it, elsewhere as Python has it."""
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
