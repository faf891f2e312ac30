"""Denies the process files, sockets, new processes and much memory, by means of the operating system.

=============  =====================================  ========================================
system         means of confinement                   denials that are missing
=============  =====================================  ========================================
Linux          resource limits; on x86-64 and 64-bit  none; on other processors seccomp
               ARM seccomp too (kernel 3.17)
macOS          resource limits except memory          seccomp, the limit of memory
Windows        none; the parent ends it in time       all
=============  =====================================  ========================================

seccomp is a filter of system calls.

Sources: seccomp(2); linux/filter.h and linux/seccomp.h for the constants of the filter, <asm/unistd.h> for the numbers of the
system calls.
"""

import ctypes
import os
import platform
import sys

try:
    import resource
except ImportError:  # Windows
    resource = None
LIMITS = ("RLIMIT_AS", "RLIMIT_CPU", "RLIMIT_CORE", "RLIMIT_FSIZE", "RLIMIT_NPROC", "RLIMIT_NOFILE")


def confine(memory: int, seconds: float) -> dict[str, str]:
    """Give up, for good, what this system can take away; return the failures by name, with the reason."""
    left_out = {**set_limits(memory, seconds), "seccomp": give_up_calls()}
    return {name: why for name, why in left_out.items() if why}


def set_limits(memory: int, seconds: float, known=resource, *, opens_files: bool = False) -> dict[str, str]:
    """Set the limits, and return those that could not be set, with the reason.

    Under ``RLIMIT_NOFILE`` = 0 no file, socket or pipe can be opened; open ones stay so. A limit that is lower already (``ulimit
    -v``) is not raised.

    Args:
        memory: Bytes of address space.
        seconds: Processor time.
        known: The module ``resource``, or a test's replacement.
        opens_files: Whether the process still opens files and starts threads.
    """
    if known is None:
        return dict.fromkeys(LIMITS, "this system has none")
    wanted = dict(zip(LIMITS, (memory, int(seconds) + 1, 0, 0, 0, 0), strict=True))
    if opens_files:
        del wanted["RLIMIT_NPROC"], wanted["RLIMIT_NOFILE"]
    failed = {name: _set(known, name, value) for name, value in wanted.items()}
    return {name: why for name, why in failed.items() if why}


def _set(known, name: str, wanted: int) -> str:
    """Set a limit; returns the reason if it failed, otherwise ""."""
    try:
        kind = getattr(known, name)
        most = known.getrlimit(kind)[1]
        value = wanted if most == known.RLIM_INFINITY else min(wanted, most)
        known.setrlimit(kind, (value, value))
    except (AttributeError, ValueError, OSError) as error:  # macOS has RLIMIT_AS, and refuses it
        return str(error) or type(error).__name__
    return ""


_NO_NEW_PRIVILEGES = 38  # an option of prctl
_SET_FILTER, _ALL_THREADS = 1, 1
_LOAD_WORD, _JUMP_IF_EQUAL, _RETURN = 0x20, 0x15, 0x06  # BPF_LD|BPF_W|BPF_ABS, BPF_JMP|BPF_JEQ|BPF_K, BPF_RET|BPF_K
_NUMBER_AT, _MACHINE_AT = 0, 4  # in struct seccomp_data
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000 | 1, 0x80000000  # the second with EPERM
_CALLS = {
    "x86_64": (0xC000003E, 317),  # AUDIT_ARCH_X86_64, the number of seccomp itself
    "aarch64": (0xC00000B7, 277),
}
ALLOWED = {  # name: (on x86_64, on aarch64). Open pipes, memory, time, exit
    "read": (0, 63), "write": (1, 64), "close": (3, 57), "fstat": (5, 80), "lseek": (8, 62),
    "mmap": (9, 222), "mprotect": (10, 226), "munmap": (11, 215), "brk": (12, 214), "mremap": (25, 216), "madvise": (28, 233),
    "rt_sigaction": (13, 134), "rt_sigprocmask": (14, 135), "rt_sigreturn": (15, 139), "sigaltstack": (131, 132),
    "restart_syscall": (219, 128), "sched_yield": (24, 124), "futex": (202, 98), "set_robust_list": (273, 99),
    "rseq": (334, 293), "membarrier": (324, 283), "getpid": (39, 172), "gettid": (186, 178),
    "getrandom": (318, 278), "getrusage": (98, 165), "gettimeofday": (96, 169), "clock_gettime": (228, 113),
    "nanosleep": (35, 101), "clock_nanosleep": (230, 115), "exit": (60, 93), "exit_group": (231, 94),
}  # fmt: skip


class _Step(ctypes.Structure):
    """``struct sock_filter``."""

    _fields_ = (("code", ctypes.c_uint16), ("if_so", ctypes.c_uint8), ("if_not", ctypes.c_uint8), ("value", ctypes.c_uint32))


class _Program(ctypes.Structure):
    """``struct sock_fprog``."""

    _fields_ = (("length", ctypes.c_uint16), ("steps", ctypes.POINTER(_Step)))


def has_seccomp() -> bool:
    """Whether this is Linux on a machine with known system call numbers."""
    return sys.platform.startswith("linux") and platform.machine() in _CALLS


def give_up_calls() -> str:
    """Give up all system calls except those ``ALLOWED``, in all threads; returns the reason if it failed, otherwise ""."""
    if not has_seccomp():
        return "this system has no seccomp, or its numbers are not known here"
    kernel = ctypes.CDLL(None, use_errno=True)
    machine = platform.machine()
    program = _filter(machine)
    if kernel.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0):
        return os.strerror(ctypes.get_errno())
    failed = kernel.syscall(_CALLS[machine][1], _SET_FILTER, _ALL_THREADS, ctypes.byref(program))
    return os.strerror(ctypes.get_errno() or 1) if failed else ""


def _filter(machine: str) -> _Program:
    """A filter that kills calls of another machine (32 bit), allows listed calls, and refuses all others with EPERM."""
    audit, column = _CALLS[machine][0], list(_CALLS).index(machine)
    steps = [_Step(_LOAD_WORD, 0, 0, _MACHINE_AT), _Step(_JUMP_IF_EQUAL, 1, 0, audit), _Step(_RETURN, 0, 0, _KILL)]
    steps.append(_Step(_LOAD_WORD, 0, 0, _NUMBER_AT))
    for numbers in ALLOWED.values():
        steps += [_Step(_JUMP_IF_EQUAL, 0, 1, numbers[column]), _Step(_RETURN, 0, 0, _ALLOW)]
    steps.append(_Step(_RETURN, 0, 0, _REFUSE))
    return _Program(len(steps), (_Step * len(steps))(*steps))
