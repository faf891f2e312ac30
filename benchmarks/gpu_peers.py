"""Measures other libraries on the same GPU: frax (JAX), pytorch_kinematics (PyTorch), and the speed of a copy.

Each runs in a process of its own, since both libraries keep the memory that they have taken. What is not installed is said.
Every time is the median of repeated calls, each until its end. ``off`` is the largest difference of the poses from Ulna's.

``python -m benchmarks.gpu_peers`` runs them all; ``python -m benchmarks.gpu_peers frax`` runs one.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import ulna
from benchmarks.peer import bare_urdf

_N, _SAMPLE, _REPEATS = 1 << 20, 200, 7
_COPIED = 1 << 28  # numbers of four bytes
_TIME = 90.0  # [s] for each library, its compilation included


def _per_second(n: int, work: Callable[[], Any], wait: Callable[[Any], Any]) -> float:
    """Problems per second; wait: waits for a result."""
    wait(work())
    times = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        wait(work())
        times.append(time.perf_counter() - start)
    return n / float(np.median(times))


def _panda() -> tuple[ulna.Robot, Any]:
    panda = ulna.load("panda")
    return panda, np.random.default_rng(0).uniform(panda.lower, panda.upper, (_N, panda.n_dof))


def of_copy() -> list[dict[str, Any]]:
    """A copy from device to device, in bytes read and written, by Numba."""
    from numba import cuda  # noqa: PLC0415 - each library in its own process

    kind: Any = np.float32
    source, target = cuda.device_array(_COPIED, kind), cuda.device_array(_COPIED, kind)
    rate = _per_second(_COPIED, lambda: target.copy_to_device(source), lambda _: cuda.synchronize())
    return [{"what": "copy", "bytes_per_second": 8.0 * rate}]


def of_frax() -> list[dict[str, Any]]:
    """Poses and Jacobians by frax, in both number types."""
    os.environ["XLA_PYTHON_CLIENT_PREALLOCATE"] = "false"
    import jax  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    from benchmarks.peers import frax  # noqa: PLC0415

    panda, q = _panda()
    arm, lines = frax.arm_of(panda), []
    for kind in (np.float64, np.float32):
        there = jax.device_put(q.astype(kind), jax.devices("gpu")[0])
        for name, method in (("poses", arm.ee_transform), ("Jacobians", arm.ee_jacobian)):
            call = jax.jit(jax.vmap(method))
            rate = _per_second(_N, lambda c=call, a=there: c(a), lambda found: found.block_until_ready())
            lines.append({"what": f"frax, {name}, {np.dtype(kind)}", "per_second": rate})
    return lines


def of_pytorch_kinematics() -> list[dict[str, Any]]:
    """Poses and Jacobians by pytorch_kinematics, in both number types."""
    import pytorch_kinematics  # noqa: PLC0415 # pyright: ignore[reportMissingImports]
    import torch  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    panda, q = _panda()
    expected, lines = panda.forward_kinematics(q[:_SAMPLE]), []
    for kind in (torch.float64, torch.float32):
        chain = pytorch_kinematics.build_serial_chain_from_urdf(bare_urdf(panda).encode(), panda.tip, panda.base)
        chain, there = chain.to(dtype=kind, device="cuda"), torch.from_numpy(q).to("cuda", kind)
        found = chain.forward_kinematics(there[:_SAMPLE]).get_matrix().double().cpu().numpy()
        for name, method in (("poses", chain.forward_kinematics), ("Jacobians", chain.jacobian)):
            rate = _per_second(_N, lambda m=method, a=there: m(a), lambda _: torch.cuda.synchronize())
            lines.append({"what": f"pytorch_kinematics, {name}, {kind}", "per_second": rate})
        lines[-2]["off"] = float(np.abs(found - expected).max())
    return lines


PEERS: dict[str, Callable[[], list[dict[str, Any]]]] = {
    "copy": of_copy, "frax": of_frax, "pytorch_kinematics": of_pytorch_kinematics,
}  # fmt: skip


def measure(name: str) -> None:
    """Print the figures of one peer as JSON, or why there are none."""
    try:
        lines = PEERS[name]()
    except Exception as error:  # noqa: BLE001 - the other peers are still wanted
        lines = [{"what": name, "absent": f"{type(error).__name__}: {error}"[:300]}]
    for line in lines:
        print(json.dumps(line), flush=True)


def main(arguments: list[str] | None = None) -> None:
    """Measure the named peers, each in its own process."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peer", nargs="?", choices=PEERS)
    options = parser.parse_args(arguments)
    if options.peer:
        measure(options.peer)
        return
    for name in PEERS:
        try:
            subprocess.run([sys.executable, "-m", "benchmarks.gpu_peers", name], check=False, timeout=_TIME)  # noqa: S603
        except subprocess.TimeoutExpired:
            print(json.dumps({"what": name, "absent": f"stopped after {_TIME:.0f} s"}), flush=True)


if __name__ == "__main__":
    main()
