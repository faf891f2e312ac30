"""A real Dask cluster of processes on the loopback interface: a scheduler and two workers, each of which can be killed."""

import contextlib
import signal
import sys
from types import SimpleNamespace

from processes import free_port, running

PYTHON = (sys.executable, "-m")
# What the workers load first: a chunk takes longer, so that there is a middle of a run in which something can be killed.
SLOWLY = """
import time
from ulna.reachability import chunk
if not hasattr(chunk, "at_once"):  # Dask runs this file twice
    chunk.at_once = chunk.compute
    chunk.compute = lambda *arguments: (time.sleep(0.05), chunk.at_once(*arguments))[1]
"""


@contextlib.contextmanager
def cluster_of(folder, n_workers=2):
    """Its address, its scheduler and its workers; all of them have ended when the block does."""
    (folder / "slowly.py").write_text(SLOWLY)
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    scheduler = (*PYTHON, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    worker = (*PYTHON, "distributed.cli.dask_worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny")
    worker += ("--no-dashboard", "--preload", str(folder / "slowly.py"), "--local-directory", str(folder))
    with contextlib.ExitStack() as stack, (folder / "cluster.log").open("w") as log:

        def start(command):
            return stack.enter_context(running(*command, end_with=signal.SIGKILL, stdout=log, stderr=log))

        yield SimpleNamespace(
            address=address,
            scheduler=start(scheduler),
            workers=[start(worker) for _ in range(n_workers)],
            start_worker=lambda: start(worker),
        )


@contextlib.contextmanager
def client_of(cluster, n_workers=2):
    """A client that sees the workers."""
    from distributed import Client

    client = Client(cluster.address, set_as_default=False, timeout="60s")
    try:
        client.wait_for_workers(n_workers, timeout=120)
        yield client
    finally:
        with contextlib.suppress(Exception):  # its scheduler may be gone
            client.close(timeout=1)
