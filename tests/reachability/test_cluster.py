"""A map computed by a real cluster: the same bits, whatever is killed meanwhile."""

import contextlib
import logging
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest

import ulna
from map_files import SMALL, files_of, verdicts_of
from processes import free_port, running, wait_for
from ulna.reachability import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="it has no SIGKILL")
WHOLE = {**SMALL, "keep_solutions": True}
N_CHUNKS = 49
# A program that is a client of the cluster, in a process of its own.
CLIENT = """
import sys, ulna
from distributed import Client
from ulna.reachability import grid
grid.POSES_OF_A_CHUNK = 64
with Client(sys.argv[2]) as client:
    client.wait_for_workers(2)
    ulna.reachability_map(ulna.load("panda"), sys.argv[1], voxel=0.3, orientations=8, keep_solutions=True, client=client)
"""
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


@pytest.fixture
def cluster(tmp_path):
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # it logs at length that what was killed is gone
    (tmp_path / "cluster").mkdir()
    with cluster_of(tmp_path / "cluster") as cluster:
        yield cluster


@pytest.fixture
def warned(cluster, monkeypatch):
    """What it warns of; at each warning another worker is started."""
    texts = []

    def start_another(text, *_, **__):
        texts.append(text)
        cluster.start_worker()

    monkeypatch.setattr(run, "warnings", SimpleNamespace(warn=start_another))
    return texts


def once_begun(kill):
    """A ``progress`` that kills when some poses, and not all, are computed."""
    killed = []

    def tell(done, total):
        if 0 < done < total and not killed:
            killed.append(done)
            kill()

    return tell, killed


@pytest.mark.process
def test_a_cluster_computes_the_same_bits(panda, panda_map, many_chunks, cluster, tmp_path):
    path = tmp_path / "m.zarr"
    with client_of(cluster) as client:
        found = ulna.reachability_map(panda, path, client=client, **WHOLE)
    assert found.grid.n_chunks == N_CHUNKS
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
def test_a_worker_that_is_killed_loses_nothing(panda, panda_map, many_chunks, cluster, tmp_path):
    path = tmp_path / "m.zarr"
    tell, killed = once_begun(cluster.workers[0].kill)
    with client_of(cluster) as client:
        ulna.reachability_map(panda, path, client=client, progress=tell, **WHOLE)
    assert killed
    assert cluster.workers[0].wait() == -9
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
def test_without_any_worker_left_it_says_so_and_waits_for_one(panda, panda_map, many_chunks, cluster, tmp_path, warned):
    path = tmp_path / "m.zarr"

    def kill_all():
        for worker in cluster.workers:
            worker.kill()

    tell, killed = once_begun(kill_all)
    with client_of(cluster) as client:
        ulna.reachability_map(panda, path, client=client, progress=tell, **WHOLE)
    assert killed
    assert len(warned) == 1
    assert "no worker now" in warned[0]
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
def test_an_outcome_that_is_lost_with_its_worker_is_waited_for(panda_map, cluster, warned, monkeypatch):
    """The workers are killed between the end of a task and the fetching of its outcome."""
    from distributed import cfexecutor

    held, fetch = [], cfexecutor._cascade_future
    monkeypatch.setattr(cfexecutor, "_cascade_future", lambda *futures: held.append(futures))
    with client_of(cluster) as client:
        tasks = run.DaskWorkers(client)
        tasks.submit(str(panda_map.path), (0,))
        wait_for(lambda: held and held[0][0].done(), "a task that has ended", looks=None)
        for worker in cluster.workers:
            worker.kill()
            worker.wait()
        wait_for(lambda: not client.nthreads(), "a scheduler that has seen it", looks=None)
        client.loop.add_callback(fetch, *held[0])
        (outcome,) = tasks.next_done()
    assert outcome.poses == panda_map.grid.poses_of(0)
    assert len(warned) == 1


@pytest.mark.process
def test_a_scheduler_that_goes_away_is_an_error_and_the_map_goes_on(panda, panda_map, many_chunks, cluster, tmp_path):
    path = tmp_path / "m.zarr"
    tell, killed = once_begun(cluster.scheduler.kill)
    with client_of(cluster) as client, pytest.raises(ulna.ClusterError):
        ulna.reachability_map(panda, path, client=client, progress=tell, **WHOLE)
    assert killed
    assert 0 < len(verdicts_of(path)) < N_CHUNKS
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    ulna.reachability_map(panda, path, resume=True, **WHOLE)
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
@pytest.mark.parametrize("gone", [("client",), ("client", "workers", "scheduler")], ids="+".join)
def test_a_client_that_is_killed_and_all_with_it_leaves_a_map_that_goes_on(
    panda, panda_map, many_chunks, cluster, tmp_path, gone
):
    path, program = tmp_path / "m.zarr", tmp_path / "client.py"
    program.write_text(CLIENT)
    with subprocess.Popen([sys.executable, program, path, cluster.address], stderr=subprocess.DEVNULL) as client:
        wait_for(lambda: len(verdicts_of(path)) > 5, "chunks on the disk", looks=None)
        client.kill()
    if "scheduler" in gone:
        for process in (*cluster.workers, cluster.scheduler):
            process.kill()
            process.wait()
        assert 5 < len(verdicts_of(path)) < N_CHUNKS
        ulna.reachability_map(panda, path, resume=True, **WHOLE)
    else:
        with client_of(cluster) as again:
            ulna.reachability_map(panda, path, resume=True, client=again, **WHOLE)
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
def test_a_task_that_fails_on_a_worker_says_why(panda, many_chunks, cluster, tmp_path):
    """The folder of the map is taken away while the cluster computes."""
    path = tmp_path / "m.zarr"
    tell, _ = once_begun(lambda: path.rename(tmp_path / "elsewhere"))
    with client_of(cluster) as client, pytest.raises(ulna.FileError, match=r"m\.zarr"):
        ulna.reachability_map(panda, path, client=client, progress=tell, **WHOLE)


@pytest.mark.filterwarnings("ignore:the cluster has no worker now")  # on a busy machine a worker is late
@pytest.mark.process
def test_the_command_uses_a_cluster(cluster, ask, run, tmp_path):
    words = "reach", "panda", tmp_path / "m.zarr", "--voxel", "0.3", "--orientations", "8"
    found = ask(*words, "--scheduler", cluster.address)
    assert (found.poses, found.computed) == (2744, 2744)
    assert found.seconds > 0
    lost = run("reach", "panda", tmp_path / "o.zarr", "--voxel", "0.3", "--orientations", "8", "--scheduler", "nowhere://1")
    assert lost.exit_code == 2
    assert "no scheduler can be reached at nowhere://1" in lost.stderr
