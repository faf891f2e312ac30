"""What seccomp and the resource limits each refuse to the child process, one at a time.

The first test shows that each attempt succeeds in a process that is not confined.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from ulna.description.xacro.child import confinement

HAS_SECCOMP = confinement.has_seccomp()
ATTEMPTS = {
    "read": "open('/etc/hostname').read()",
    "read its own code": "open(os.__file__).read()",
    "write": "open('MARK', 'w')",
    "list": "os.listdir('/etc')",
    "remove": "os.remove('VICTIM')",
    "make a folder": "os.mkdir('MARK')",
    "rename": "os.rename('VICTIM', 'MARK')",
    "link": "os.symlink('/etc', 'MARK')",
    "change a mode": "os.chmod('VICTIM', 0)",
    "look": "os.stat('/etc/hostname')",
    "leave": "os.chdir('/')",
    "fork": "os._exit(0) if os.fork() == 0 else os.wait()",
    "start": "subprocess.run(['true'])",
    "become": "os.execv('/bin/true', ['true'])",
    "connect": "socket.socket().bind(('127.0.0.1', 0))",
    "a pair of sockets": "socket.socketpair()",
    "a Unix socket": "socket.socket(socket.AF_UNIX).bind('MARK')",
    "signal": "os.kill(os.getppid(), 0)",
    "trace": "kernel.ptrace(16, os.getppid(), 0, 0) + 1 or 1 / 0",
    "a thread": "threading.Thread(target=dict).start()",
    "share memory": "os.memfd_create('m')",
    "raise a limit": "resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))",
}
BY_LIMITS = ("read", "read its own code", "write", "list", "connect", "a pair of sockets", "a Unix socket", "share memory")
NOT_TRIED_FREELY = ("trace", "become")
PROGRAM = """
import sys; sys.path[:] = {path!r}
import ctypes, os, resource, socket, subprocess, threading
from ulna.description.xacro.child import confinement
kernel = ctypes.CDLL(None)
assert not {confine}, {confine}
try:
    {attempt}
except (OSError, RuntimeError, ValueError, ZeroDivisionError):
    os.write(1, b"refused")
else:
    os.write(1, b"done")
"""


def try_in_child(confine: str, name: str, place: Path) -> str:
    (place / "victim").touch()
    attempt = ATTEMPTS[name].replace("MARK", str(place / "mark")).replace("VICTIM", str(place / "victim"))
    program = PROGRAM.format(path=sys.path, confine=confine, attempt=attempt)
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False).stdout


@pytest.mark.process
@pytest.mark.skipif(sys.platform != "linux", reason="the attempts are those of Linux")
@pytest.mark.parametrize("name", [name for name in ATTEMPTS if name not in NOT_TRIED_FREELY])
def test_an_attempt_succeeds_without_confinement(name, tmp_path):
    assert try_in_child("''", name, tmp_path) == "done"


@pytest.mark.process
@pytest.mark.skipif(not HAS_SECCOMP, reason="the numbers of this machine's system calls are not known")
@pytest.mark.parametrize("name", ATTEMPTS)
def test_seccomp_alone_refuses(name, tmp_path):
    assert try_in_child("confinement.give_up_calls()", name, tmp_path) == "refused"


@pytest.mark.process
@pytest.mark.skipif(sys.platform != "linux", reason="the attempts are those of Linux")
@pytest.mark.parametrize("name", BY_LIMITS)
def test_the_limits_alone_refuse(name, tmp_path):
    assert try_in_child("confinement.set_limits(1 << 31, 20)", name, tmp_path) == "refused"


@pytest.mark.process
@pytest.mark.skipif(not HAS_SECCOMP, reason="the numbers of this machine's system calls are not known")
def test_seccomp_and_limits_work_together(tmp_path):
    assert try_in_child("confinement.confine(1 << 31, 20)", "read", tmp_path) == "refused"


@pytest.mark.skipif(not Path("/usr/include/asm-generic/unistd.h").is_file(), reason="the kernel's headers are not installed")
def test_the_system_call_numbers_of_arm_are_those_of_the_kernel_headers():
    generic = Path("/usr/include/asm-generic/unistd.h").read_text()  # of aarch64, among others
    for name, (_, number) in confinement.ALLOWED.items():
        assert re.search(rf"^#define __NR(_|3264_){name} {number}$", generic, re.MULTILINE), name


@pytest.mark.skipif(not Path("/usr/include/x86_64-linux-gnu/asm/unistd_64.h").is_file(), reason="these headers are not installed")
def test_the_system_call_numbers_of_x86_64_are_those_of_the_kernel_headers():
    header = Path("/usr/include/x86_64-linux-gnu/asm/unistd_64.h").read_text()
    for name, (number, _) in confinement.ALLOWED.items():
        assert re.search(rf"^#define __NR_{name} {number}$", header, re.MULTILINE), name
