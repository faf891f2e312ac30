"""What a document can do if the check of its expressions is switched off: each layer behind it still refuses it.

Another test shows that without these layers, too, the same attempts succeed.
"""

import textwrap
from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError
from ulna.description.xacro import expansion
from ulna.description.xacro.child import confinement

CONFINED = pytest.mark.skipif(not confinement.has_seccomp(), reason="the system has no seccomp, or its numbers are not known")
UNCHECKED = """
import os, socket, subprocess
from ulna.description.xacro.child import main as program
names = {**vars(os), **vars(socket), **vars(subprocess), "open": open, "__import__": __import__}
program.evaluate = lambda text, lookup: eval(text, {"__builtins__": names})
"""
UNCONFINED = "program.confine = lambda *_: {}\n"
ESCAPES = {
    "read": "open('/etc/hostname').read()",
    "write": "open('MARK', 'w')",
    "start": "Popen(['touch', 'MARK'])",
    "run": "system('touch MARK')",
    "connect": "socket()",
    "import": "__import__('this')",
}


def switch_off_the_check(monkeypatch, and_then: str = "") -> None:
    """Make the child evaluate any Python."""
    before, start = expansion._START.split("main()\n")[0], "main()\n"
    monkeypatch.setattr(expansion, "_START", before + textwrap.dedent(UNCHECKED) + and_then + start)


def expanded(name: str, place: Path) -> tuple:
    expression = ESCAPES[name].replace("MARK", str(place / "mark"))
    return ulna.load(
        f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="${{{expression}}}"/></robot>'
    ).link_names


@pytest.mark.process
@CONFINED
@pytest.mark.parametrize("name", ESCAPES)
def test_a_confined_child_refuses_what_an_unchecked_expression_tries(name, tmp_path, monkeypatch):
    switch_off_the_check(monkeypatch)
    if name == "run":
        assert expanded(name, tmp_path) in {("-1",), ("32512",)}  # by which system() says that there was no shell
    else:
        with pytest.raises(DescriptionError, match=r"not permitted|No module named|denied"):
            expanded(name, tmp_path)
    assert not (tmp_path / "mark").exists()


@pytest.mark.process
@pytest.mark.parametrize("name", ["read", "write", "run", "connect", "import"])
def test_without_confinement_an_unchecked_expression_succeeds(name, tmp_path, monkeypatch):
    switch_off_the_check(monkeypatch, UNCONFINED)
    assert len(expanded(name, tmp_path)) == 1
    assert name not in ("write", "run") or (tmp_path / "mark").exists()
