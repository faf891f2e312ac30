"""Makes programs of Ulna for another Python, which executes nothing next to the user's files.

Python is isolated (``-I``). It searches modules in this process's absolute paths only, the interpreter's first.
"""

import json
import os
import sys
from pathlib import Path

_START = """
import json, sys, types
sys.path += [path for path in json.loads(sys.argv[2]) if path not in sys.path]
ulna = sys.modules["ulna"] = types.ModuleType("ulna")
ulna.__path__ = [sys.argv[1]]
from {module} import main
main()
"""  # the package without its __init__, which would import NumPy


def program_of(module: str) -> str:
    """A program that calls the function ``main`` of a module of this package."""
    return _START.format(module=module)


def command_of(program: str, *arguments: str) -> list[str]:
    """The command that runs a program of ``program_of``, which finds further arguments behind its own two."""
    paths = [path for path in sys.path if isinstance(path, str) and os.path.isabs(path)]  # noqa: PTH117 - text in, text out
    options = ["-I", "-X", "utf8", *(["-B"] if sys.dont_write_bytecode else [])]
    return [sys.executable, *options, "-c", program, str(Path(__file__).parents[1]), json.dumps(paths), *arguments]
