"""Refuses files, imports and processes by an audit hook (PEP 578), a weak second line.

An audit hook is not a sandbox: Python code in this process can reach the hook and disable it. It guards against mistakes in Ulna,
such as a file that xacro opens, or a module that it imports, without asking the parent; on Windows and macOS nothing else does.
"""

import sys

from ulna.description.xacro.child.refused import RefusedError

_REFUSED = ("open", "import", "os.", "subprocess.", "socket.", "shutil.", "glob.", "ctypes.", "pty.", "tempfile.", "sys._", "gc.")


def audit_hook(event: str, arguments: tuple) -> None:
    """Refuse an event that evaluating expressions does not need.

    Raises:
        RefusedError: It opens or lists files, imports, starts a process, or the like.
    """
    if event.startswith(_REFUSED):
        words = " ".join(argument for argument in arguments if isinstance(argument, str))[:80]
        raise RefusedError(f"a description may not do this: {event} {words}".rstrip())


def add_audit_hook() -> None:
    """Install the hook, for as long as the process runs."""
    sys.addaudithook(audit_hook)
