"""Sets the POSIX limits of the process: memory, processor time, files, processes."""

try:
    import resource
except ImportError:  # Windows
    resource = None
LIMITS = ("RLIMIT_AS", "RLIMIT_CPU", "RLIMIT_CORE", "RLIMIT_FSIZE", "RLIMIT_NPROC", "RLIMIT_NOFILE")


def set_limits(memory: int, seconds: float, known=resource) -> dict[str, str]:
    """Set the limits, and return those that could not be set, with the reason.

    No file, socket or pipe can be opened under ``RLIMIT_NOFILE`` = 0; those that are open stay so. Where a limit is lower
    already (``ulimit -v``), it stays as low.

    Args:
        memory: Bytes of address space.
        seconds: Of the processor's time.
        known: The module ``resource``, or what a test gives in its place.
    """
    if known is None:
        return dict.fromkeys(LIMITS, "this system has none")
    wanted = dict(zip(LIMITS, (memory, int(seconds) + 1, 0, 0, 0, 0), strict=True))
    failed = {name: _set(known, name, value) for name, value in wanted.items()}
    return {name: why for name, why in failed.items() if why}


def _set(known, name: str, wanted: int) -> str:
    """Why a limit could not be set; nothing if it was."""
    try:
        kind = getattr(known, name)
        most = known.getrlimit(kind)[1]
        value = wanted if most == known.RLIM_INFINITY else min(wanted, most)
        known.setrlimit(kind, (value, value))
    except (AttributeError, ValueError, OSError) as error:  # macOS knows RLIMIT_AS, and refuses it
        return str(error) or type(error).__name__
    return ""
