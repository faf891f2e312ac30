"""One more line, and a weak one: an audit hook (PEP 578), by which this interpreter itself refuses files, imports and processes.

It is no sandbox. Whoever runs Python code of his own in this process can reach the hook and what it does. It is there for a
fault of ours: a file that xacro would open, or a module that it would import, behind the parent's back.
"""

import sys

from ulna.description.xacro.child.refused import RefusedError

_REFUSED = ("open", "import", "os.", "subprocess.", "socket.", "shutil.", "glob.", "ctypes.", "pty.", "tempfile.", "sys._", "gc.")


def audit_hook(event: str, arguments: tuple) -> None:
    """Refuse an event that has no place in computing."""
    if event.startswith(_REFUSED):
        words = " ".join(argument for argument in arguments if isinstance(argument, str))[:80]
        raise RefusedError(f"a description may not do this: {event} {words}".rstrip())


def add_audit_hook() -> None:
    """From now on, for as long as the process lasts."""
    sys.addaudithook(audit_hook)
