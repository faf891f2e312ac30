"""The child process that expands a xacro document: a JSON request on standard input, a JSON answer on standard output."""

import json
import os
import re
import sys
from pathlib import Path
from typing import Any


def main() -> None:
    """Expand and answer; whatever goes wrong is a sentence in the answer."""
    request = json.load(sys.stdin)
    _limit(request["memory"], request["seconds"])
    try:
        answer = {"urdf": _expand(request)}
    except RecursionError:
        answer = {"error": "a macro calls itself without end"}
    except MemoryError:
        answer = {"error": "out of memory"}
    except Exception as error:  # xacro raises whatever the document's expressions raise
        answer = {"error": _sentence(error)}
    json.dump(answer, sys.stdout)


def _sentence(error: BaseException) -> str:
    """What went wrong, once, in one line."""
    inner: BaseException | None = error
    while inner is not None:
        if isinstance(inner, MemoryError):
            return "out of memory " + " ".join(str(error).split())
        inner = getattr(inner, "exc", None) or inner.__cause__ or inner.__context__
    text = re.sub(r"<class '[\w.]+'>: ", "", " ".join(str(error).split()))
    half = len(text) // 2
    if len(text) % 2 == 1 and text[:half] == text[half + 1 :]:
        text = text[:half]
    return re.sub(r" \[Errno \d+\].*", "", text) or type(error).__name__


def _limit(memory: int, seconds: float) -> None:
    try:
        import resource
    except ImportError:  # Windows: the parent's time limit alone
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))


def _expand(request: dict) -> str:
    import xacro
    from xacro import substitution_args

    from ulna.io.packages import find_package

    folder = None if request["folder"] is None else Path(request["folder"])

    def find(name: str) -> str:
        package = find_package(name, folder, request["package_dirs"])
        if package is None:
            raise LookupError(f"$(find {name}): no such package in package_dirs, ROS_PACKAGE_PATH or the folders above the file")
        return str(package)

    substitution_args._eval_find = find  # noqa: SLF001 - xacro asks ament, which only ROS 2 has
    if folder is not None:
        os.chdir(folder)
    document: Any = xacro.parse(request["text"])
    xacro.process_doc(document, mappings=request["arguments"])
    return document.toprettyxml(indent="  ")


if __name__ == "__main__":
    main()
