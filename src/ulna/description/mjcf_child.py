"""Compiles a model by MuJoCo in a child process, since a stranger's small file can exhaust memory and time."""

import json
import os
import sys
from importlib import import_module
from types import ModuleType
from typing import Any

from ulna.description.xacro.child.confinement import set_limits

MAX_MODEL = 1 << 28  # bytes of a compiled model


def main() -> None:
    """Compile the model of a request; write a line of JSON, and then the compiled model."""
    reply = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # MuJoCo prints its warnings
    mujoco, numpy = import_module("mujoco"), import_module("numpy")
    request, limits = json.loads(sys.stdin.buffer.read()), json.loads(sys.argv[-1])
    set_limits(limits["memory"], limits["seconds"], opens_files=True)
    try:
        content = _compiled(request, mujoco, numpy)
    except MemoryError:
        line, content = {"error": "out of memory"}, b""
    except Exception as error:  # noqa: BLE001 - MuJoCo raises errors of several kinds
        line, content = {"error": " ".join(str(error).split())[:200]}, b""
    else:
        line = {"size": len(content)}
    reply.write(json.dumps(line).encode() + b"\n" + content)
    reply.flush()


def _compiled(request: dict[str, Any], mujoco: ModuleType, numpy: ModuleType) -> bytes:
    """The compiled model of a file, or of a text."""
    path, text = request["path"], request["text"]
    model = mujoco.MjModel.from_xml_string(text) if path is None else mujoco.MjModel.from_xml_path(path)
    size = mujoco.mj_sizeModel(model)
    if size > MAX_MODEL:
        raise ValueError(f"the compiled model has {size / 1e6:.0f} MB; up to {MAX_MODEL / 1e6:.0f} MB are read")
    content = numpy.empty(size, numpy.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content.tobytes()
