"""Takes files, processes, sockets and much memory from the process, by the operating system.

=============  =====================================  ========================================
system         what holds                             what is left out
=============  =====================================  ========================================
Linux          limits; on x86-64 and ARM seccomp      nothing on those two
               (kernel 3.17)
macOS          limits but that of memory              seccomp, the limit of memory
Windows        nothing; the parent ends it in time    all
=============  =====================================  ========================================
"""

from ulna.description.xacro.child.limits import set_limits
from ulna.description.xacro.child.seccomp import give_up_calls


def confine(memory: int, seconds: float) -> dict[str, str]:
    """Give up, for good, what this system can take away; return the rest by name, with the reason."""
    left_out = {**set_limits(memory, seconds), "seccomp": give_up_calls()}
    return {name: why for name, why in left_out.items() if why}
