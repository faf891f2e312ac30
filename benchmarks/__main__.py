"""``python -m benchmarks``: measures Ulna and its peers on the same robots and targets, and writes Markdown and JSON."""

import argparse
import json
import os
import subprocess
import sys
import warnings
from datetime import date
from pathlib import Path

import numpy as np

from benchmarks import first_use
from benchmarks.account import account_rows
from benchmarks.bounds import bound_rows, copy_ns, peak_ns
from benchmarks.cold_cache import cold_rows
from benchmarks.collision import collision_data
from benchmarks.forces import force_data
from benchmarks.inverse import protocol_rows
from benchmarks.kinematics import batch_rows, single_call_rows
from benchmarks.markdown import page
from benchmarks.peer import PEERS, Peer, make_peer
from benchmarks.processors import one_processor
from benchmarks.scaling import joint_rows, size_rows
from ulna.bench.arms import NAMES, load_arm, path_positions
from ulna.bench.protocol import PROTOCOLS, Forward, Solver, follow_path, ulna_solver
from ulna.bench.timing import installed_version, machine_facts, time_each
from ulna.engine.ahead import is_ahead
from ulna.errors import UlnaError
from ulna.robot import Robot

RESULTS = Path(__file__).parent / "results"
KINEMATICS_ON = ("panda", "ur5")  # the cost of a call depends on the number of joints, hardly on the arm
FOLLOW_LONGEST_S = 10.0  # time limit of one pass along the path
FOLLOW = ("ulna", "roboticstoolbox-python", "pytracik", "ssik")  # solvers that accept a start configuration


def main() -> None:
    """Measure, and write the page and the figures."""
    options = _options()
    warnings.simplefilter("ignore")  # warnings of the peers, which we cannot fix
    data = {
        "machine": {**machine_facts(), "commit": _commit(), "load": " ".join(f"{load:.1f}" for load in os.getloadavg())},
        "versions": {name: installed_version(name) for name in PEERS},
        "forward_kinematics": [],
        "jacobian": [],
        "account": [],
        "batches": [],
        "forces": [],
        "protocols": [],
        "tracking": [],
        "scaling_with_joints": [],
        "scaling_with_rows": [],
        "collision": [],
        "scaling_with_pairs": [],
        "edges": [],
        "moving": [],
        "bounds": [],
        "first_use": [],
        "first_use_ever": [],
        "memory": [],
        "size": [],
        "absent": [],
    }
    for name in options.robot or NAMES:
        try:
            measure(name, load_arm(name), options.n, data)
        except UlnaError as error:
            _say(str(error))
            data["absent"].append({"robot": name, "peer": "all", "why": str(error)})
    if not options.peers_only:
        _say("dynamics, collision, scaling, bounds, first use")
        panda, peak, copy = load_arm("panda"), peak_ns(), copy_ns()
        data["forces"], why = force_data(panda)
        data["absent"] += [{"robot": "panda", "peer": "pin, dynamics", "why": why}] * bool(why)
        tables, why = collision_data(panda, peak)
        data.update(tables)
        data["absent"] += [{"robot": "panda", "peer": "pin with coal", "why": why}] * bool(why)
        data["account"] = [] if is_ahead() else account_rows(panda)  # code compiled ahead is called in another way: docs/ahead.md
        data.update(scaling_with_joints=joint_rows(peak), scaling_with_rows=size_rows(panda, peak, copy))
        with one_processor():  # as the bound assumes
            data["bounds"] = bound_rows("panda", panda, peak, copy)
        data.update(first_use=first_use.first_use_rows(), first_use_ever=[] if is_ahead() else cold_rows())
        data.update(memory=first_use.memory_rows(), size=first_use.size_rows())
    _write(data, options.out)


def measure(name: str, robot: Robot, n: int, data: dict) -> None:
    """Add the rows of one robot."""
    peers = {}
    for peer in PEERS:
        made, why = make_peer(peer, robot)
        if made is None:
            _say(f"{name}: {peer}: {why}")
            data["absent"].append({"robot": name, "peer": peer, "why": why})
        else:
            peers[peer] = made
    if name in KINEMATICS_ON:
        for kind in ("forward_kinematics", "jacobian"):
            _say(f"{name}: {kind}")
            data[kind] += single_call_rows(name, robot, peers, kind)
            data["batches"] += batch_rows(name, robot, peers, kind)
    forward = _judge(robot)
    for protocol in PROTOCOLS:
        _say(f"{name}: protocol {protocol}")
        count = n if PROTOCOLS[protocol].reachable else max(1, n // 10)
        data["protocols"] += protocol_rows(name, robot, protocol, _solvers(robot, peers, protocol), count, forward)
    for solver in _solvers(robot, peers, "reachable"):
        if solver.name in FOLLOW:
            _say(f"{name}: tracking by {solver.name}")
            _track(name, robot, solver, 10 * n, forward, data)


def _track(name: str, robot: Robot, solver: Solver, n: int, forward: Forward, data: dict) -> None:
    """Add the row of a solver that follows n poses, or the reason for its absence."""
    path = path_positions(robot, n, seed=1)[:20]
    steps = [(solver.prepare(T), q) for T, q in zip(robot.forward_kinematics(path), path, strict=True)]
    pose_ns = float(np.median(time_each(solver.solve, steps)))
    if pose_ns * n > FOLLOW_LONGEST_S * 1e9:
        why = f"too slow to follow {n} poses: {pose_ns / 1e6:.1f} ms a pose"
        data["absent"].append({"robot": name, "peer": solver.name, "why": why})
    else:
        data["tracking"].append({**follow_path(solver, robot, n, forward), "robot": name})


def _solvers(robot: Robot, peers: dict[str, Peer], protocol: str) -> list:
    theirs = [peer.solver(PROTOCOLS[protocol]) for peer in peers.values() if peer.solver is not None]
    return [ulna_solver(robot, PROTOCOLS[protocol]), *theirs]


def _judge(robot: Robot):
    """Pinocchio's forward kinematics, or Ulna's own if it is absent."""
    try:
        from benchmarks.peers.pinocchio import Model  # noqa: PLC0415 -- it may be absent
    except ImportError:
        _say("pin is absent: answers are judged by Ulna's own forward kinematics")
        return robot.forward_kinematics
    return Model(robot).forward_all


def _write(data: dict, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{date.today().isoformat()}.md"  # noqa: DTZ011 -- the reader's day
    path.write_text(page(data), encoding="utf-8")
    path.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(page(data))
    _say(f"written: {path}")


def _commit() -> str:
    """The measured commit, marked if the files differ from it."""
    command = ["git", "describe", "--always", "--dirty"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=Path(__file__).parent)  # noqa: S603
    return done.stdout.strip() or "unknown"


def _say(line: str) -> None:
    sys.stderr.write(f"{line}\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--robot", action="append", choices=NAMES, help="repeatable; all of them unless given")
    parser.add_argument("--n", type=int, default=1000, help="targets of each protocol (default 1000)")
    parser.add_argument("--peers-only", action="store_true", help="leave out dynamics, collision, scaling, bounds and first use")
    parser.add_argument("--out", type=Path, default=RESULTS, help="the folder to write to")
    return parser.parse_args()


if __name__ == "__main__":
    main()
