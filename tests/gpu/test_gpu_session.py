"""``make gpu`` runs tests, figures and peers within a budget, and says what it leaves out; here without a GPU."""

import json
import time

import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from benchmarks import gpu_peers, gpu_session, gpu_timing
from numba import types

H200 = gpu_timing.Limits()


@pytest.fixture
def steps(monkeypatch):
    """The steps that a session runs: their names, arguments and times."""
    ran = []

    def noted(step, arguments, seconds):
        ran.append((step.name, arguments, seconds))
        return f"{step.name}: passed"

    monkeypatch.setattr(gpu_session.Step, "run", noted)
    return ran


def test_what_has_changed_is_measured_first_after_the_tests(steps, tmp_path):
    gpu_session.main(["--first", "edges,clouds", "--out", str(tmp_path)])
    assert [name for name, _, _ in steps] == ["tests", "figures", "peers"]
    figures = steps[1][1]
    assert figures[figures.index("--first") + 1] == "edges,clouds"
    assert float(figures[figures.index("--seconds") + 1]) < steps[1][2] < 480.0


def test_a_session_stays_within_its_budget(steps, tmp_path):
    gpu_session.main(["--seconds", "100", "--out", str(tmp_path)])
    (_, _, tests), (_, _, figures), (_, _, peers) = steps
    assert tests == pytest.approx(100.0 * gpu_session.TESTS)
    assert figures < 100.0 * (1.0 - gpu_session.PEERS)
    assert peers < 100.0


def test_what_is_left_out_is_said(steps, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(gpu_session, "has", lambda name: name != "frax")
    gpu_session.main(["--without-tests", "--out", str(tmp_path)])
    said = capsys.readouterr().out
    assert "tests: left out" in said
    assert "not installed: frax" in said
    monkeypatch.setattr(gpu_session, "has", lambda _: False)
    gpu_session.main(["--out", str(tmp_path)])
    assert "tests: left out, pytest is not installed" in capsys.readouterr().out


def test_a_part_that_there_is_not_is_refused_before_anything_runs(steps, tmp_path, capsys):
    with pytest.raises(SystemExit):
        gpu_session.main(["--first", "unheard-of", "--out", str(tmp_path)])
    assert "no such part: unheard-of" in capsys.readouterr().err
    assert not steps


def test_a_step_is_stopped_at_its_end_and_its_output_is_kept(tmp_path):
    start = time.monotonic()
    said = gpu_session.Step("slow", tmp_path).run(["-u", "-c", "print('begun'); import time; time.sleep(60)"], 2.0)
    assert said.startswith("slow: stopped after")
    assert time.monotonic() - start < 30.0
    assert (tmp_path / "slow.txt").read_text().strip() == "begun"
    assert gpu_session.Step("good", tmp_path).run(["-c", ""], 30.0).startswith("good: passed")
    assert gpu_session.Step("bad", tmp_path).run(["-c", "raise SystemExit(3)"], 30.0).startswith("bad: failed with code 3")


def test_a_peer_that_is_not_installed_is_said(capsys, monkeypatch):
    def missing():
        raise ModuleNotFoundError("No module named 'frax'")

    monkeypatch.setitem(gpu_peers.PEERS, "frax", missing)
    gpu_peers.main(["frax"])
    assert json.loads(capsys.readouterr().out) == {"what": "frax", "absent": "ModuleNotFoundError: No module named 'frax'"}


@pytest.mark.parametrize(
    ("registers", "shared", "block", "expected"),
    [
        (68, 0, 128, 896),  # 72 registers a thread, 9216 a block: seven blocks
        (32, 0, 128, 2048),
        (32, 48 << 10, 128, 512),  # four blocks with 49 kB each
        (32, 0, 8, 256),  # 32 blocks, each of a warp that is not full
        (255, 0, 128, 256),
    ],
)
def test_threads_at_once_are_bounded_by_registers_shared_memory_and_blocks(registers, shared, block, expected):
    assert gpu_timing.threads_at_once(registers, shared, block, H200) == expected


def test_the_pause_before_a_timed_launch_compiles(ptx_of_driver):
    assert "nanosleep" in ptx_of_driver(gpu_timing.pause, types.void())
