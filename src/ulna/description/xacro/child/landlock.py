"""Takes files, sockets and signals from a Linux process for good, by Landlock. Used by ``confinement``.

Source: linux/landlock.h, and https://docs.kernel.org/userspace-api/landlock.html.
"""

import ctypes
import os
import sys

_CREATE_RULESET, _RESTRICT_SELF = 444, 446  # system calls, of one number on all machines
_ASK_VERSION = 1  # a flag of the first
_NO_NEW_PRIVILEGES = 38  # an option of prctl
_FILE_RIGHTS = {1: 13, 2: 14, 3: 15, 5: 16}  # by version: how many rights of files there are, as bits from the lowest
_BIND_AND_CONNECT, _SIGNALS_AND_SOCKETS = 3, 3  # TCP since version 4; abstract Unix sockets and signals since 6


class _Handled(ctypes.Structure):
    """``struct landlock_ruleset_attr``: the rights that the rules decide about."""

    _fields_ = (("files", ctypes.c_uint64), ("network", ctypes.c_uint64), ("scopes", ctypes.c_uint64))


def version() -> int:
    """The version of Landlock that the kernel has; 0 if none."""
    if not sys.platform.startswith("linux"):
        return 0
    return max(0, ctypes.CDLL(None).syscall(_CREATE_RULESET, None, 0, _ASK_VERSION))


def give_up_files() -> str:
    """Give up every right that the kernel's version knows, and return why that failed; nothing if it did not."""
    known = version()
    if not known:
        return "this system has no Landlock"
    bits = max(count for since, count in _FILE_RIGHTS.items() if since <= known)
    handled = _Handled((1 << bits) - 1, _BIND_AND_CONNECT * (known >= 4), _SIGNALS_AND_SOCKETS * (known >= 6))
    size = 8 * (1 + (known >= 4) + (known >= 6))
    kernel = ctypes.CDLL(None, use_errno=True)
    if kernel.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0):
        return _reason()
    rules = kernel.syscall(_CREATE_RULESET, ctypes.byref(handled), size, 0)
    if rules < 0:
        return _reason()
    failed = kernel.syscall(_RESTRICT_SELF, rules, 0)
    reason = _reason() if failed else ""
    os.close(rules)
    return reason


def _reason() -> str:
    return os.strerror(ctypes.get_errno())
