"""The command as a whole: help, version, exit statuses, pipes, signals, plugins."""

import itertools
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from importlib.metadata import EntryPoint

import pytest

import ulna
from command_fixtures import without_announcements
from ulna.cli import plugins

COMMANDS = [
    *("view", "servo", "record", "fk", "jacobian", "ik", "torque", "check", "reach", "plan", "follow", "run"),
    *("list", "info", "dh", "compare", "inspect", "urdf", "bench", "warmup"),
]
OF_PLUGINS = ("demo", "ros1", "ros2")  # tests/demo
FAR = "5,0,0,0,0,0,1,1,1"
ANSWERS = [
    ["list", "pan"],
    ["info"],
    ["fk"],
    ["fk", "--q", "0 0 0 0 0 0 3"],
    ["jacobian"],
    ["jacobian", "--analytical", "--q", "-2.8 -1.7 -2.8 -3.0 -2.8 3.7 -2.8"],
    ["ik", "--xyz", "-0.4,-0.1,0.5"],
    ["torque", "--payload", "14kg@0,0,0.1"],
    ["check", "--box", "0,0,0,0,0,0,9,9,9"],
    ["dh"],
    ["compare", "panda", "panda"],
    ["inspect"],
    ["dh", "--convention", "standard", "--link", "panda_link8"],
]
ENDLESS = """
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background would have it ignored
import ulna.cli.app
import ulna.cli.info

def endless(tree, link):
    print("started", flush=True)
    time.sleep(60)

ulna.cli.info.closed_form_of = endless
ulna.cli.app.app(["info"], prog_name="ulna")
"""


def command(*arguments):
    return [sys.executable, "-m", "ulna", *arguments]


def spawn(arguments, **options):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=240, check=False, **options)


@pytest.mark.slow
@pytest.mark.parametrize("width", [80, 100, 60])
@pytest.mark.parametrize("arguments", ANSWERS, ids=" ".join)
def test_no_line_is_wider_than_the_terminal_and_no_number_is_truncated(run, arguments, width):
    shown = run(*arguments, COLUMNS=str(width)).stdout
    assert max(map(len, shown.splitlines())) <= max(width, 80)
    assert "…" not in shown


def test_only_a_terminal_gets_colors(run):
    assert "\x1b[" in run("fk", FORCE_COLOR="1").stdout
    assert "\x1b[" not in run("fk").stdout


@pytest.mark.parametrize("arguments", ANSWERS, ids=" ".join)
def test_help_documents_every_key_of_the_json(run, arguments):
    answer = json.loads(run(*arguments, "--json").stdout)
    documented = re.findall(r"\w+", run(arguments[0], "--help").stdout.partition("JSON: ")[2])
    assert [key for key in answer if key not in documented] == []


def test_help_lists_the_commands(run):
    result = run("--help")
    assert result.exit_code == 0
    listed = re.findall(r"^│ (\w+)  ", result.stdout, flags=re.MULTILINE)
    assert [name for name in listed if name not in OF_PLUGINS] == COMMANDS


def test_help_groups_the_commands(run):
    panels = re.findall(r"^╭─ ([\w ]+) ─", run("--help").stdout, flags=re.MULTILINE)
    assert panels[1:6] == ["Look", "Compute", "Plan and move", "Describe", "This machine"]
    assert "Commands" not in panels


@pytest.mark.parametrize("arguments", [(), ("ik",), ("check",), ("reach", "map"), ("record",)])
def test_no_flag_is_shown_as_if_it_took_a_value(run, arguments):
    shown = run(*arguments, "--help").stdout
    assert "--help" in shown
    assert "<bool>" not in shown.lower()


@pytest.mark.parametrize("width", [80, 120])
def test_help_is_printed_as_it_is_written_in_whole_lines(run, width):
    """Brackets are no markup, and no line ends before it is full, but where a paragraph does."""
    for arguments, words in ((["plan"], "[rad/s^2 or m/s^2]"), (["follow"], "[rad or m]")):
        shown = " ".join(run(*arguments, "--help", COLUMNS=str(width)).stdout.replace("│", " ").split())
        assert words in shown
    lines = run("reach", "map", "--help", COLUMNS=str(width)).stdout.splitlines()
    for line, after in itertools.pairwise(lines[: next(k for k, line in enumerate(lines) if "Arguments" in line)]):
        assert not after.strip() or not line.strip() or len(f"{line.rstrip()} {after.split()[0]}") > width - 1


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help(run, name):
    result = run(name, "--help")
    assert result.exit_code == 0
    assert f"Usage: ulna {name}" in result.stdout


def test_a_file_that_is_missing_is_one_error_in_one_wording(refusal):
    for arguments in (
        ("follow", "--path", "none.csv"),
        ("check", "--scene", "none.csv"),
        ("check", "--cloud", "none.csv"),
        ("ik", "--xyz", "0.4,0,0.5", "--srdf", "none.csv"),
        ("record", "a.mp4", "--plan", "none.csv"),
    ):
        assert re.match(r"(--\w+: )?none\.csv: no such file$", refusal(*arguments))
    assert refusal("info", "none.urdf").startswith("none.urdf: no such file")


def test_version(run):
    assert run("--version").stdout == f"ulna {ulna.__version__}\n"


@pytest.mark.parametrize("arguments", [["nonsense"], ["fk", "--nonsense"], ["info", "panda", "more"]])
def test_usage_errors_are_exit_status_2(run, arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""


@pytest.mark.process
def test_python_m_ulna_runs_the_command():
    result = spawn(command("fk", "--json"))
    assert (result.returncode, without_announcements(result.stderr)) == (0, "")
    assert json.loads(result.stdout)["position"] == pytest.approx([0.306891, 0, 0.486882], abs=5e-7)


@pytest.mark.process
def test_python_m_ulna_returns_the_exit_status():
    assert spawn(command("check", "--box", FAR)).returncode == 0
    assert spawn(command("check", "--box", "0,0,0,0,0,0,9,9,9")).returncode == 1
    refused = spawn(command("fk", "--q", "1"))
    assert refused.returncode == 2
    assert refused.stdout == ""
    assert refused.stderr.startswith("ulna: --q: ")


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize("arguments", [["info"], ["info", "--json"], ["urdf"]], ids=" ".join)
def test_a_closed_pipe_prints_no_error(arguments):
    reading, writing = os.pipe()
    os.close(reading)
    result = subprocess.run(command(*arguments), stdout=writing, stderr=subprocess.PIPE, text=True, timeout=240, check=False)
    os.close(writing)
    assert (result.returncode, result.stderr) == (141, "")


@pytest.mark.process
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")  # noqa: PTH110
def test_a_full_disk_is_a_one_line_error():
    with open("/dev/full", "w") as full:  # noqa: PTH123
        result = subprocess.run(command("info"), stdout=full, stderr=subprocess.PIPE, text=True, timeout=240, check=False)
    assert (result.returncode, result.stderr) == (2, "ulna: No space left on device\n")


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_prints_no_error():
    with subprocess.Popen([sys.executable, "-c", ENDLESS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "started\n"
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=240)
    assert (process.returncode, out, err) == (130, "", "")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("module", ["typer", "rich.markup", "ulna.cli.app", "ulna.cli.fk", "numpy", "ulna.robot"])
def test_ctrl_c_during_imports_prints_no_error(module):
    """A finder sends the signal when the module is asked for; in a shell's background it is ignored, so it is set here."""
    code = f"""
import os, runpy, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
sys.argv = ["ulna", "fk"]
runpy.run_module("ulna", run_name="__main__", alter_sys=True)
print("not interrupted")
"""
    result = spawn([sys.executable, "-c", code])
    assert (result.returncode, result.stdout, result.stderr) == (130, "", "")


@pytest.mark.process
@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_a_name_that_the_terminal_cannot_encode_is_no_error(odd, encoding):
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    result = subprocess.run(
        command("ik", str(odd), "--link", "bäll", "--xyz", "0 0 0.5"),
        capture_output=True,
        env=environment,
        timeout=240,
        check=False,
    )
    assert (result.returncode, without_announcements(result.stderr.decode())) == (0, "")
    assert b"solved" in result.stdout


def test_a_plugin_that_was_deleted_is_skipped(monkeypatch):
    entries = [
        EntryPoint("gone", "ulna.gone.command:commands", plugins.COMMANDS),
        EntryPoint("here", "math:pi", plugins.COMMANDS),
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: [entry for entry in entries if entry.group == group])
    assert plugins.load_plugins(plugins.COMMANDS) == [math.pi]


def test_a_plugin_with_a_missing_import_is_an_error(monkeypatch, tmp_path):
    (tmp_path / "plugin.py").write_text("import a_module_that_is_nowhere")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [EntryPoint("plugin", "plugin:commands", group)])
    with pytest.raises(ModuleNotFoundError, match="a_module_that_is_nowhere"):
        plugins.load_plugins(plugins.COMMANDS)


@pytest.mark.process
def test_importing_the_command_imports_neither_numba_nor_the_viewer():
    code = "import sys, ulna.cli.app; print([m for m in ('numba', 'llvmlite', 'viser', 'trimesh') if m in sys.modules])"
    assert spawn([sys.executable, "-c", code]).stdout == "[]\n"


@pytest.mark.process
def test_help_info_and_urdf_do_not_import_numba():
    for arguments in (["--help"], ["info"], ["urdf"]):
        code = f"import sys, ulna.cli.app; ulna.cli.app.app({arguments}, standalone_mode=False); sys.exit('numba' in sys.modules)"
        assert spawn([sys.executable, "-c", code]).returncode == 0


@pytest.mark.process
def test_a_command_imports_no_other_command_and_no_plugin():
    code = "import sys, ulna.cli.app; ulna.cli.app.app(['fk'], standalone_mode=False); print(*sorted(sys.modules))"
    loaded = spawn([sys.executable, "-c", code]).stdout.splitlines()[-1].split()
    assert [name for name in loaded if name.startswith("ulna.cli.")] == [
        f"ulna.cli.{name}" for name in ("app", "depends", "fk", "options", "output", "quiet_imports", "targets")
    ]
    assert not [name for name in loaded if name.startswith(("ulna.bench", "ulna.demo"))]


def test_a_mistyped_command_gets_a_suggestion(run):
    assert "Did you mean 'warmup'" in run("warmpu").stderr


@pytest.mark.parametrize(
    ("arguments", "kind"),
    [
        (["fk", "--q", "1"], "InputError"),
        (["info", "nix"], "FileError"),
        (["fk", "--nonsense"], "NoSuchOption"),
        (["nix"], "UsageError"),
    ],
)
def test_with_json_an_error_is_json(run, arguments, kind):
    result = run(*arguments, "--json")
    assert (result.exit_code, result.stdout) == (2, "")
    answer = json.loads(result.stderr)
    assert answer["error"] == kind
    assert answer["message"]


def test_control_characters_in_names_are_escaped(run, tmp_path):
    evil = "\x1b]0;owned\x07\u200f\r\x9b2J"
    scene = {"ulna_scene": 1, "objects": [{"name": evil, "shape": "box", "extents": [1, 1, 1]}]}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    (tmp_path / "a.urdf").write_text('<robot name="\u202e\x9b2J"><link name="\u200fa\x85b"/></robot>', encoding="utf-8")
    results = [run("check", "--scene", tmp_path / "scene.json"), run("info", tmp_path / "a.urdf"), run("fk", tmp_path / evil)]
    results.append(run("fk", tmp_path / "a.urdf", "--link", evil))
    for result in results:
        assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200f\u202e]", result.stdout + result.stderr)
    assert "\\x1b]0;owned" in results[0].stdout.replace("\n", "")
