"""``ulna list``, and shell completion."""

import os
import re
import subprocess
import sys

import pytest

import ulna
from ulna.description.names import cached_descriptions


def test_robots_listed_as_installed_can_be_loaded(ask):
    robots = ask("list").robots
    assert {"panda", "ur5", "tiago"} <= {robot["name"] for robot in robots}
    assert len({robot["path"] for robot in robots if robot["path"]}) == sum(robot["path"] is not None for robot in robots)
    broken = {"alex_psyonic_hands", "ur3"}  # tests/crosscheck has the reasons
    for robot in robots[:: 1 + len(robots) // 12]:
        for name in (robot["name"], *robot["also"]):
            if robot["installed"] and robot["name"] not in broken:
                assert ulna.load(name).link_names


def test_a_part_of_a_name_or_package_filters_the_list(ask, run):
    answer = ask("list", "UR5")
    names = [name for robot in answer.robots for name in (robot["name"], *robot["also"])]
    assert {"ur5", "ur5_robot"} <= set(names)
    assert all("ur5" in robot["name"] + "".join(robot["also"]) for robot in answer.robots)
    assert {"panda", "fr3", "ur10e", "gen3_7"} <= {robot["name"] for robot in ask("list", "bundled").robots}
    assert [(robot["name"], robot["model"]) for robot in ask("list", "fanuc").robots] == [("crx10ia", "CRX-10iA")]
    row = next(line for line in run("list", "crx").stdout.splitlines() if "crx10ia" in line)
    assert re.search(r"FANUC CRX-10iA +10 +1.249", row)
    none = run("list", "no such robot")
    assert (none.exit_code, none.stdout.splitlines()[0]) == (1, "no robot matches")


def test_a_name_is_listed_once_for_the_robot_that_it_loads(ask):
    robots = ask("list").robots
    names = [name for robot in robots for name in (robot["name"], *robot["also"])]
    assert len(set(names)) == len(names)
    assert [robot["package"] for robot in robots if robot["name"] == "panda"] == ["bundled"]


def test_a_robot_that_is_not_downloaded_is_marked(run, monkeypatch, tmp_path):
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "_repositories.py").write_text(
        "from types import SimpleNamespace\nREPOSITORIES = {'r': SimpleNamespace(cache_path='r')}"
    )
    (package / "arm9_description.py").write_text(
        "from ._cache import clone_to_cache\nURDF_PATH = clone_to_cache('r') + '/arm9.urdf'"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    assert "arm9" in cached_descriptions.names()
    row = next(line for line in run("list", "arm9").stdout.splitlines() if "arm9" in line)
    assert row.split()[-2:] == ["not", "downloaded"]
    (tmp_path / "cache" / "r").mkdir(parents=True)
    assert "not downloaded" not in run("list", "arm9").stdout


def test_the_error_for_an_unknown_robot_refers_to_ulna_list(refusal):
    assert "`ulna list` prints them" in refusal("info", "zzzzzzzz")


def completions(*words):
    environment = {
        **os.environ,
        "_ULNA_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    result = subprocess.run(
        [sys.executable, "-c", "from ulna.cli.app import app; app(prog_name='ulna')"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=240,
        check=True,
    )
    return result.stdout.split()


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "expected"),
    [(["ulna", "warm"], ["warmup"]), (["ulna", "fk", "--deg"], ["--degrees"]), (["ulna", "info", "pand"], ["panda"])],
    ids=str,
)
def test_a_shell_completes_commands_options_and_robots(words, expected):
    assert set(completions(*words)) >= set(expected)


@pytest.mark.process
def test_the_completion_script_is_printed():
    code = "from ulna.cli.app import app; app(['--show-completion', 'bash'], prog_name='ulna')"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True,
                           env={**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}).stdout  # fmt: skip
    assert "complete -o default -F _ulna_completion ulna" in shown
