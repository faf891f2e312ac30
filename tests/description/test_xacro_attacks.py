"""Malicious documents: nothing is written, and no content of other files appears in the text or the error.

The attacks are real: some of them are run against the package xacro itself, where they succeed.
"""

import subprocess
import sys
from html import escape
from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError
from xacro_attacks import DOCUMENTS, EXPRESSIONS, OPENS_BY_FRAMES, PLACES, READS_BY_FRAMES, RUNS_BY_FRAMES, SUBSTITUTIONS

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
CANARY = "canary-of-7f3a"
LAUGHS = "".join(f'<!ENTITY l{k + 1} "{f"&l{k};" * 10}">' for k in range(9))


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder for a document and its parts, with secret files beside it."""
    monkeypatch.setenv("CANARY", CANARY)
    (tmp_path / "in").mkdir()
    files = {
        "secret.yaml": f"word: {CANARY}",
        "secret.xacro": f'<robot {NAMESPACE}><link name="{CANARY}"/></robot>',
        "in/part.xacro": f"<robot {NAMESPACE}/>",
        "in/objects.yaml": f"a: !!python/object/apply:os.system ['touch {tmp_path}/mark']",
        "in/unit.yaml": f'a: !degrees "{OPENS_BY_FRAMES.replace("MARK", f"{tmp_path}/mark")}"',
        "in/comment.xacro": f"<robot><!-- xacro:eval-comments --><!-- ${{{armed(OPENS_BY_FRAMES, tmp_path)}}} --></robot>",
        "in/entities.xacro": f'<!DOCTYPE r [<!ENTITY e SYSTEM "{tmp_path}/secret.yaml">]><robot>&e;</robot>',
        "in/laughs.xacro": f'<!DOCTYPE r [<!ENTITY l0 "ha">{LAUGHS}]><robot><link name="&l9;"/></robot>',
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "in" / "linked.xacro").symlink_to(tmp_path / "secret.xacro")
    (tmp_path / "in" / "linked.yaml").symlink_to(tmp_path / "secret.yaml")
    (tmp_path / "in" / "linked").symlink_to(tmp_path)
    return tmp_path


def armed(text: str, place: Path) -> str:
    for word, meant in {"MARK": "mark", "SECRET": "secret.yaml", "FOLDER": ""}.items():
        text = text.replace(word, str(place / meant).rstrip("/"))
    return text


def assert_refused(place: Path, body: str) -> None:
    file = place / "in" / "r.xacro"
    file.write_text(f'<robot name="r" {NAMESPACE}>{armed(body, place)}</robot>')
    with pytest.raises(DescriptionError, match=r"^r\.xacro(: xacro: | \(expanded; .* not XML)") as caught:
        ulna.load(file)
    assert not (place / "mark").exists()
    assert CANARY not in str(caught.value)
    assert "died" not in str(caught.value)


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_a_malicious_expression_is_refused(place, name):
    assert_refused(place, f'<link name="${{{escape(EXPRESSIONS[name])}}}"/>')


@pytest.mark.parametrize("name", SUBSTITUTIONS)
def test_a_malicious_substitution_is_refused(place, name):
    assert_refused(place, f'<link name="{SUBSTITUTIONS[name]}"/>')


@pytest.mark.parametrize("name", DOCUMENTS)
def test_a_malicious_document_is_refused(place, name):
    assert_refused(place, DOCUMENTS[name])


@pytest.mark.parametrize("name", PLACES)
def test_a_malicious_expression_is_refused_wherever_xacro_evaluates(place, name):
    assert_refused(place, PLACES[name].replace("ATTACK", escape(OPENS_BY_FRAMES)))


@pytest.mark.parametrize("pattern", ["link*.xacro", "linked/*.xacro", "*/*cret.xacro"])
def test_a_glob_pattern_does_not_follow_links_to_the_outside(place, pattern):
    file = place / "in" / "r.xacro"
    file.write_text(f'<robot name="r" {NAMESPACE}><xacro:include filename="{pattern}"/><link name="own${{1}}"/></robot>')
    try:
        assert ulna.load(file).link_names == ("own1",)
    except DescriptionError as error:
        assert "lies outside" in str(error)  # noqa: PT017


@pytest.mark.parametrize("dtd", ['<!ENTITY e SYSTEM "SECRET">', f'<!ENTITY l0 "ha">{LAUGHS}<!ENTITY e "&l9;">'])
def test_entities_of_the_document_itself_are_refused(place, dtd):
    with pytest.raises(DescriptionError, match="entities"):
        ulna.load(f'<!DOCTYPE r [{armed(dtd, place)}]><robot {NAMESPACE}><link name="&e;${{1}}"/></robot>')


def test_code_in_an_argument_of_the_caller_is_not_executed(place):
    file = place / "in" / "r.xacro"
    file.write_text(f'<robot name="r" {NAMESPACE}><xacro:arg name="a" default="1"/><link name="${{$(arg a)}}"/></robot>')
    with pytest.raises(DescriptionError, match="invalid name __import__"):
        ulna.load(file, xacro_args={"a": armed("__import__('os').system('touch MARK')", place)})
    assert not (place / "mark").exists()


def test_control_characters_in_an_error_are_escaped():
    fatal = r"${xacro.fatal('\x1b]0;mine\x07')}"
    with pytest.raises(DescriptionError, match=r"xacro: \\x1b\]0;mine\\x07"):
        ulna.load(f'<robot name="r" {NAMESPACE}><link name="{fatal}"/></robot>')


PLAIN_XACRO = "import sys, xacro; print(xacro.process_doc(d := xacro.parse(sys.stdin.read())) or d.toxml())"


@pytest.mark.parametrize("attack", [OPENS_BY_FRAMES, RUNS_BY_FRAMES, READS_BY_FRAMES])
def test_the_attacks_succeed_with_the_package_xacro(place, attack):
    text = f'<robot {NAMESPACE}><link name="${{{escape(armed(attack, place))}}}"/></robot>'
    done = subprocess.run([sys.executable, "-c", PLAIN_XACRO], input=text, capture_output=True, text=True, check=True)
    assert (place / "mark").exists() or CANARY in done.stdout


@pytest.mark.parametrize("place_of_it", PLACES)
def test_the_package_xacro_evaluates_in_each_of_these_places(place, place_of_it):
    body = PLACES[place_of_it].replace("ATTACK", escape(armed(OPENS_BY_FRAMES, place)))
    text = f"<robot {NAMESPACE}>{body}</robot>"
    subprocess.run([sys.executable, "-c", PLAIN_XACRO], input=text, capture_output=True, text=True, check=False, cwd=place / "in")
    assert (place / "mark").exists()
