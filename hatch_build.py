"""Builds the wheel that needs no compiler at its user's, where ``ULNA_AHEAD=1`` asks for it (``make wheel``).

``ULNA_AHEAD=lowest`` builds one for tests, in a third of the time: for the lowest level of CPU alone.

Without it, as for an editable install or from a source distribution, the wheel is of Python alone: Numba compiles its code when
it is first called, and no C compiler is needed. docs/ahead.md explains the steps.
"""

import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

AHEAD = os.environ.get("ULNA_AHEAD", "").replace("0", "")
X86_LEVELS = {"x86-64-v2": 2, "x86-64-v3": 3, "x86-64-v4": 4}  # and the number that the CPU must have (native/cpu.c)
PACKAGE = "ulna"
PARTS = "together", "rest"  # of the entries of a level, each about half the work: ulna.engine.emit
ABI, MACRO = "cp311-abi3", "0x030B0000"  # Python 3.11 and every later one
# No multiply-add where Python has none: a number that both compute has the same bits.
COMPILED = ["-O2", "-g0", "-Wall", "-Wextra", "-fvisibility=hidden", "-ffp-contract=off"]
# All addresses are found when a library is loaded, and their table is read-only then; no symbols, no random number in the file.
LINKED = ["-Wl,-z,relro", "-Wl,-z,now", "-Wl,-z,noexecstack", "-Wl,--build-id=none", "-s"] if sys.platform == "linux" else []


class Dependencies(MetadataHookInterface):
    """The project's dependencies: Numba's is left out where code is compiled ahead."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        metadata["dependencies"] = sorted([*self.config["needed"], *([] if AHEAD else self.config["compiler"])])


class MachineCode(BuildHookInterface):
    """Adds the machine code of every entry, and the extension that calls it."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        config = self.build_config.builder.metadata.hatch.metadata.hook_config["custom"]
        return [*config["needed"], *config["compiler"], "numpy>=2", "setuptools>=75"] if AHEAD else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if not AHEAD or version == "editable":
            return
        build = Path(self.root, "build", "ahead")
        extension = _extension(Path(self.root), build)
        libraries = _libraries(Path(self.root), build, _levels())
        for file in libraries:
            build_data["force_include"][str(file)] = f"ulna/engine/machine_code/{file.name}"
        build_data["force_include"][str(extension)] = f"ulna/engine/{extension.name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"{ABI}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def _levels() -> dict[str, int]:
    """The levels of CPU to compile for, lowest first, with what each needs."""
    machine = platform.machine().lower()
    if machine not in {"x86_64", "amd64"}:
        return {f"{machine}-baseline": 0}
    lowest = min(X86_LEVELS)
    return {lowest: X86_LEVELS[lowest]} if AHEAD == "lowest" else X86_LEVELS


def _libraries(root: Path, build: Path, levels: dict[str, int]) -> list[Path]:
    """A library for each level, and the index of what is in them."""
    out = build / "machine_code"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    jobs = [(level, part) for part in PARTS for level in levels]
    with ThreadPoolExecutor(max(1, min(len(jobs), len(os.sched_getaffinity(0)) if sys.platform == "linux" else 2))) as pool:
        halves = dict(zip(jobs, pool.map(lambda job: _write_objects(root, build, *job), jobs), strict=True))
    written = [sorted((one for part in PARTS for one in halves[level, part]), key=lambda one: one["name"]) for level in levels]
    files = [_link(root, build, out, level, entries) for level, entries in zip(levels, written, strict=True)]
    index = {
        "package": PACKAGE,
        "levels": {
            level: {"needs": needs, **_identity(file)} for (level, needs), file in zip(levels.items(), files, strict=True)
        },
        "entries": {entry["name"]: entry for entry in written[0]},
    }
    (out / "index.json").write_text(json.dumps(index), encoding="utf-8")
    return [*files, out / "index.json"]


def _identity(file: Path) -> dict[str, Any]:
    content = file.read_bytes()
    return {"file": file.name, "size": len(content), "sha256": sha256(content).hexdigest()}


def _write_objects(root: Path, build: Path, level: str, part: str) -> list[dict[str, Any]]:
    """The object files of a part of the entries for a level, as ``ulna.engine.emit`` writes them in a process of its own."""
    cpu = "generic" if level.endswith("-baseline") else level
    settings = {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "", "NUMBA_DISABLE_JIT": "0", "ULNA_CPU": "native"}
    settings["PYTHONHASHSEED"] = "0"  # the order of sets decides the order of code
    path = os.pathsep.join([str(root / "src"), *filter(None, [os.environ.get("PYTHONPATH")])])  # pip's own for the build as well
    environment = {**os.environ, **settings, "PYTHONPATH": path}
    folder = build / level
    subprocess.run([sys.executable, "-m", "ulna.engine.emit", PACKAGE, str(folder), part], env=environment, check=True, cwd=root)
    return json.loads((folder / f"{part}.json").read_text(encoding="utf-8"))


def _link(root: Path, build: Path, out: Path, level: str, entries: list[dict[str, Any]]) -> Path:
    from setuptools._distutils.ccompiler import new_compiler
    from setuptools._distutils.sysconfig import customize_compiler

    compiler = new_compiler()
    with _no_path_of_the_builder():
        customize_compiler(compiler)
    unix = compiler.compiler_type == "unix"
    names = {name for entry in entries for overload in entry["overloads"] for name in overload["objects"]}
    objects = [str(build / level / name) for name in sorted(names)]
    source = os.path.relpath(root / "native" / "runtime.c")
    objects += compiler.compile([source], str(build / level), extra_postargs=["-O2", "-fvisibility=hidden"] if unix else [])
    file = out / f"{level}{'.dll' if os.name == 'nt' else '.so'}"
    compiler.link_shared_object(objects, str(file), extra_postargs=["-Wl,-z,defs", *LINKED] if LINKED else [])
    return file


@contextmanager
def _no_path_of_the_builder() -> Iterator[None]:
    """Within it a linker notes no folder of this Python's, in which users of a wheel would look for libraries (RUNPATH)."""
    before = os.environ.get("LDSHARED")
    if LINKED:
        words = shlex.split(before or sysconfig.get_config_var("LDSHARED"))
        os.environ["LDSHARED"] = shlex.join(word for word in words if not word.startswith("-Wl,-rpath"))
    try:
        yield
    finally:
        os.environ.pop("LDSHARED", None)
        os.environ.update({} if before is None else {"LDSHARED": before})


def _extension(root: Path, build: Path) -> Path:
    """The C extension, for every Python from 3.11 on."""
    import numpy as np
    from setuptools import Distribution, Extension

    sources = [os.path.relpath(file) for file in sorted((root / "native").glob("*.c")) if file.name != "runtime.c"]
    extension = Extension(
        "ulna.engine._calls",
        sources,
        include_dirs=[np.get_include()],
        define_macros=[("Py_LIMITED_API", MACRO)],
        extra_compile_args=COMPILED if os.name != "nt" else ["/O2"],
        extra_link_args=LINKED,
        py_limited_api=True,
    )
    command: Any = Distribution({"name": "ulna", "ext_modules": [extension]}).get_command_obj("build_ext")
    command.build_lib, command.build_temp, command.force = str(build / "lib"), str(build / "temp"), True
    command.ensure_finalized()
    with _no_path_of_the_builder():
        command.run()
    return Path(command.get_ext_fullpath("ulna.engine._calls"))
