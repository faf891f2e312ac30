"""Takes files, processes, sockets and much memory from the process, by the operating system. Used by ``main``.

=============  =====================================  ========================================
system         what holds                             what is left out
=============  =====================================  ========================================
Linux          Landlock (kernel 5.13), limits;        nothing on those two
               on x86-64 and ARM seccomp
macOS          limits but that of memory              Landlock, seccomp, the limit of memory
Windows        nothing; the parent ends it in time    all
=============  =====================================  ========================================
"""

from ulna.description.xacro.child.landlock import give_up_files
from ulna.description.xacro.child.limits import set_limits
from ulna.description.xacro.child.seccomp import give_up_calls


def confine(memory: int, seconds: float) -> dict[str, str]:
    """Give up, for good, what this system can take away; return the rest by name, with the reason."""
    left_out = {"Landlock": give_up_files(), **set_limits(memory, seconds), "seccomp": give_up_calls()}
    return {name: why for name, why in left_out.items() if why}
