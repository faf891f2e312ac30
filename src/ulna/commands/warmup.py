"""``ulna warmup``: all that is compiled on first use, compiled now."""

import time

from ulna.answers.warmup import warmup_data
from ulna.commands.options import Json
from ulna.errors import FileError
from ulna.kinematics.batches import n_processors
from ulna.tables.warmup import warmup_view, with_progress
from ulna.tables.writing import show


def warmup(*, as_json: Json = False) -> None:
    """Compile every kernel for this machine, so that no first call waits for it.

    The machine code is kept on disk: doing it again takes seconds. NUMBA_CACHE_DIR says where, as for Numba itself.
    """
    from ulna.kernels.cache import cache_folder  # noqa: PLC0415 -- they load the compiler, which other commands may not need
    from ulna.warmup import all_jobs, compile_all  # noqa: PLC0415

    folder = cache_folder()
    if folder is None:
        raise FileError("cache folder", "it cannot be written, so nothing would be kept; NUMBA_CACHE_DIR names another")
    jobs, start = all_jobs(), time.perf_counter()
    compiled = with_progress(compile_all(jobs, side_by_side=n_processors() > 1), len(jobs), in_lines=not as_json)
    data = warmup_data(str(folder), time.perf_counter() - start, compiled)
    show(data, None if as_json else warmup_view)
