"""The process that expands a document: whatever it prints or does, the parent ends it and raises an error with the reason."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

import ulna
from matrix import matrix
from ulna import DescriptionError
from ulna.description.xacro import expansion as xacro
from ulna.description.xacro.child import main

DOCUMENT = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="${1}"/>' + "<!-- long -->" * 10_000 + "</robot>"
)
SAYS = "import sys\ndef say(text): print(text, flush=True)\n"
READY = SAYS + "say('{\"left_out\": {}}')\nsys.stdin.readline()\n"
DIED = r"^URDF text: xacro: the expansion died \({0}\); its limits are 20 s and 2 GiB$"
PROGRAMS = {
    "dies with words": ("raise SystemExit('no such module')", DIED.format("no such module")),
    "dies in silence": ("import os; os._exit(3)", DIED.format("exit status .*")),
    "says what is no JSON": (SAYS + "say('hello')", DIED.format(".*")),
    "says a list": (SAYS + "say([1])", DIED.format(".*")),
    "asks for a number": (READY + "say('{\"read\": 5}')", DIED.format(".*")),
    "asks two things": (READY + 'say(\'{"read": "a", "find": "b"}\')', DIED.format(".*")),
    "asks what is not known": (READY + 'say(\'{"write": "a"}\')\nsys.stdin.readline()', DIED.format(".*")),
    "gives a number": (READY + 'say(\'{"urdf": 5, "asked": []}\')', DIED.format(".*")),
    "gives less than it says": (READY + 'say(\'{"urdf": 50, "asked": []}\')\nsay("<robot/>")', DIED.format(".*")),
    "says more than is read": (READY + 'say(\'{"urdf": 64000001, "asked": []}\')\nsay("x" * 64000001)', DIED.format(".*")),
    "nests without end": (READY + 'say("[" * 900000)', DIED.format(".*")),
    "fails without end": (READY + 'say(\'{"error": "\' + "x" * 5000000 + \'"}\')', DIED.format(".*")),
    "fails at length": (READY + 'say(\'{"error": "\' + "x" * 900000 + \'"}\')', r"^URDF text: xacro: x+ \.\.\. x+$"),
    "goes on without end": (READY + "while True: sys.stdout.write('a' * 1000)", DIED.format(".*")),
    "fails in colors": (READY + 'say(\'{"error": "\\\\u001b[31mred"}\')', r"xacro: \\x1b\[31mred$"),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_process_that_misbehaves_is_an_error(name, monkeypatch):
    program, message = PROGRAMS[name]
    monkeypatch.setattr(xacro, "_START", program)
    with pytest.raises(DescriptionError, match=message):
        ulna.load(DOCUMENT)


def test_an_error_of_hundreds_of_megabytes_costs_the_parent_little_and_is_cut(monkeypatch):
    received = []
    of_child = xacro._receive
    monkeypatch.setattr(xacro, "_receive", lambda child: received.append(of_child(child)) or received[-1])
    text = DOCUMENT.replace("${1}", "${xacro.fatal('x' * 200000000)}")
    with pytest.raises(DescriptionError, match=r"^URDF text: xacro: x{150,200}\.\.\.$"):
        ulna.load(text)
    assert len(str(received)) < 10_000


def test_a_name_of_megabytes_is_not_looked_up():
    with pytest.raises(DescriptionError, match=r"a name or a path of \d+ bytes; up to 1000000 are looked up$"):
        ulna.load(DOCUMENT.replace("<link", "<xacro:include filename=\"${'x' * 2000000}\"/><link"))


def test_a_skipped_limit_is_named_when_the_process_dies(monkeypatch):
    monkeypatch.setattr(xacro, "_START", SAYS + 'say(\'{"left_out": {"RLIMIT_AS": "not here"}}\')')
    with pytest.raises(DescriptionError, match=r"its limits are 20 s; this system has not granted RLIMIT_AS \(not here\)$"):
        ulna.load(DOCUMENT)


def test_a_process_without_output_is_ended_after_the_time_limit(monkeypatch):
    monkeypatch.setattr(xacro, "_START", "import time; time.sleep(1000)")
    monkeypatch.setattr(xacro, "TIME_LIMIT_S", 0.5)
    with pytest.raises(DescriptionError, match=r"not finished within 0\.5 s; expansion stopped$"):
        ulna.load(DOCUMENT)


def test_a_process_has_no_environment_variables_of_the_user(monkeypatch):
    monkeypatch.setenv("TOKEN", "canary")
    names = "import json, os\n" + READY + "say(json.dumps({'error': ' '.join(os.environ)}))"
    monkeypatch.setattr(xacro, "_START", names)
    with pytest.raises(DescriptionError) as caught:
        ulna.load(DOCUMENT)
    allowed = {"LC_CTYPE", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "SYSTEMROOT"}
    assert set(str(caught.value).split("xacro: ")[1].split()) <= allowed


NAMES = {f"{module.__name__}.{name}" for module, names in main._USED.items() for name in names}


@pytest.mark.parametrize("name", matrix(sorted(NAMES), 3))
def test_a_version_of_xacro_without_a_name_that_is_used_is_refused_and_the_name_said(name, monkeypatch):
    monkeypatch.setattr(xacro, "_START", f"import xacro.substitution_args\ndel {name}\n{xacro._START}")
    with pytest.raises(DescriptionError, match=rf"xacro: .*(no {name}|has no attribute '{name.rpartition('.')[2]}')"):
        ulna.load(DOCUMENT)


def test_each_name_of_xacro_that_is_used_is_listed():
    used = set()
    for file in Path(main.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id in {"xacro", "substitution_args"}
            ):
                used.add((node.value.id, node.attr))
    modules = {"xacro": "xacro", "substitution_args": "xacro.substitution_args"}
    assert {f"{modules[module]}.{name}" for module, name in used} <= NAMES
    assert all(hasattr(import_module(name.rpartition(".")[0]), name.rpartition(".")[2]) for name in NAMES)
