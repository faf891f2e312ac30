"""Malicious documents: nothing is written, and no content of other files appears in the text or the error.

The attacks are real: some of them are run against the package xacro itself, where they succeed.
"""

import subprocess
import sys
from html import escape
from pathlib import Path

import pytest

import ulna
from matrix import matrix
from ulna import DescriptionError

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
CANARY = "canary-of-7f3a"
LAUGHS = "".join(f'<!ENTITY l{k + 1} "{f"&l{k};" * 10}">' for k in range(9))

# Escapes from a xacro document. Each opens the file MARK for writing, or brings the word that lies in the file SECRET.
_FRAME = "(lambda a: [a.append((b.gi_frame.f_back for b in a)), *a[0]])([])[1]"
_PYTHON = f"(lambda w: w(w, {_FRAME}))(lambda w, f: f.f_builtins if 'open' in f.f_builtins else w(w, f.f_back))"
OPENS_BY_FRAMES = f"({_PYTHON})['open']('MARK', 'w')"
RUNS_BY_FRAMES = f"({_PYTHON})['__import__']('os').system('touch MARK')"
READS_BY_FRAMES = f"({_PYTHON})['open']('SECRET').read()"

# fmt: off
EXPRESSIONS = {
    "frames of a generator, to write": OPENS_BY_FRAMES,
    "frames of a generator, to run": RUNS_BY_FRAMES,
    "frames of a generator, to read": READS_BY_FRAMES,
    "frames of an exception": "(i for i in [1]).throw(xacro.fatal).tb_frame",
    "the code of a lambda": "(lambda: 1).f_code",
    "a lambda that is called": "(lambda x: x.__class__)(1)",
    "a comprehension": "[x.__class__ for x in [1]]",
    "a comprehension that writes an attribute": "[1 for xacro.load_yaml in [1]]",
    "a comprehension that writes an entry": "[1 for math['pi'] in [1]]",
    "a comprehension with a name of Python's": "[1 for __builtins__ in [1]]",
    "a comprehension of functions, to pass on": "[f('SECRET') for f in [open]]",
    "a comprehension of a set": "python.set(x for x in [1])",
    "a walrus": "(x := xacro)",
    "await": "(await xacro)",
    "yield": "(yield 1)",
    "an operator that calls what a class defines": "xacro @ xacro",
    "a list with a star": "[*xacro]",
    "a call with a star": "max(*[1, 2])",
    "a call with two stars": "dict(**xacro)",
    "the classes of an object": "().__class__.__base__.__subclasses__()",
    "the class of a text": "''.__class__.__mro__",
    "a name of look-alike lines": "().\ufe4d\ufe4dclass\ufe4d\ufe4d",
    "a name of wide letters": "().__\uff43lass__",
    "a single underscore": "math._x",
    "the globals of a function": "xacro.load_yaml.__globals__",
    "the old name of those": "xacro.load_yaml.func_globals",
    "the module of a function": "math.sin.__self__",
    "the methods of a class": "str.mro()",
    "an attribute of a text": "'a'.encode",
    "an attribute of a number": "(1).real",
    "a format that reads attributes": r"'\x7b0.load_yaml.__globals__\x7d'.format(xacro)",
    "a format of a mapping": r"'\x7ba.__class__\x7d'.format_map(dict(a=1))",
    "a format passed on": r"list(map(str.format, ['\x7b0.__class__\x7d'], [1]))",
    "a method passed on": "list(map(str.mro, [1]))",
    "a function of a function": "xacro.load_yaml.__call__('SECRET')",
    "a subscript of a class": "list[int]",
    "a call of what a call gives": "xacro.dotify(dict(a=open))('SECRET')",
    "a call of a subscript": "[len][0]([1])",
    "a call of a choice": "(len if 1 else str)([1])",
    "getattr": "getattr(str, 'mro')",
    "getattr of the namespace": "python.getattr(str, 'mro')",
    "type, to make a class": "python.type('X', (), dict(a=1))",
    "type": "python.type(xacro)",
    "vars": "python.vars(xacro)",
    "open": "open('SECRET').read()",
    "open of the namespace": "python.open('SECRET')",
    "import": "__import__('os').system('touch MARK')",
    "the built-in names": "__builtins__['open']('MARK', 'w')",
    "eval": "eval('1')",
    "exec": "exec('1')",
    "compile": "compile('1', '', 'eval')",
    "globals": "globals()",
    "breakpoint": "breakpoint()",
    "the stack of files": "filestack",
    "a parent of a table": "xacro.root",
    "bytes": "str(b'a', 'rot13')",
    "an ellipsis": "...",
    "a descriptor for a file's name": "xacro.load_yaml(0)",
    "YAML from outside": "xacro.load_yaml('SECRET')",
    "YAML from outside, passed on": "list(map(xacro.load_yaml, ['SECRET']))",
    "YAML from outside, as a key": "sorted(['SECRET'], key=xacro.load_yaml)",
    "YAML from outside, as an address": "xacro.load_yaml('file://SECRET')",
    "YAML with dots": "xacro.load_yaml('../secret.yaml')",
    "YAML with dots behind the folder": "xacro.load_yaml('$(dirname)/../secret.yaml')",
    "YAML from the folder of the process": "xacro.load_yaml('$(cwd)/../secret.yaml')",
    "the environment of the process": "xacro.load_yaml('/proc/self/environ')",
    "a name with a zero": r"xacro.load_yaml('a\x00b')",
    "a name with half a character": r"xacro.load_yaml('\ud800')",
    "half a character": r"'\ud800'",
    "a zero": r"'\x00'",
}
SUBSTITUTIONS = {
    "eval of a built-in name": "$(eval open)",
    "eval of an import": "$(eval __import__)",
    "eval of an attribute": "$(eval find.__globals__)",
    "eval of a class": "$(eval [].append.__class__)",
    "eval of an f-string": "$(eval f'{pi.__class__}')",
    "eval of what math holds": "$(eval __loader__)",
    "an environment variable": "$(env CANARY)",
    "a package by a path": "$(find ../..)",
    "a package by a hidden name": "$(find .ssh)",
    "an unknown word": "$(shell touch MARK)",
}
_INCLUDE = '<xacro:include filename="{}"/>'
DOCUMENTS = {
    "an include with dots": _INCLUDE.format("../secret.xacro"),
    "an include by its path": _INCLUDE.format("FOLDER/secret.xacro"),
    "an include by an address": _INCLUDE.format("file://FOLDER/secret.xacro"),
    "an include by a package's address": _INCLUDE.format("package://../secret.xacro"),
    "an include by a package with dots": _INCLUDE.format("package://in/../secret.xacro"),
    "an include by a pattern": _INCLUDE.format("../sec*.xacro"),
    "an include by a pattern with dots behind it": _INCLUDE.format("*/../../secret.xacro"),
    "an include through a link": _INCLUDE.format("linked.xacro"),
    "an include through a linked folder": _INCLUDE.format("linked/secret.xacro"),
    "a comment that is evaluated": _INCLUDE.format("comment.xacro"),
    "an include of a file with entities": _INCLUDE.format("entities.xacro"),
    "an include of a file that laughs": _INCLUDE.format("laughs.xacro"),
    "YAML that builds Python's objects": "<link name=\"${xacro.load_yaml('objects.yaml')}\"/>",
    "YAML whose unit is an expression": "<link name=\"${xacro.load_yaml('unit.yaml')}\"/>",
    "YAML through a link": "<link name=\"${xacro.load_yaml('linked.yaml')}\"/>",
    "a property of the built-in names": '<xacro:property name="__builtins__" value="1"/><link name="${open}"/>',
    "a property that hides a function": '<xacro:property name="len" value="1"/><link name="${len(\'SECRET\')}"/>',
    "a property that is a class": '<xacro:property name="c" value="${str}"/><link name="${c.mro()}"/>',
    "an argument that is an expression": '<xacro:arg name="a" default="open(\'SECRET\')"/><link name="${$(arg a)}"/>',
    "a macro's name that is an expression": '<xacro:call macro="${().__class__}"/>',
    "a macro's name that climbs": '<xacro:call macro="__class__.__init__"/>',
}
# fmt: on
_ATTACK = "${ATTACK}"
PLACES = {
    "a link's name": f'<link name="{_ATTACK}"/>',
    "a text": f'<link name="${{1}}">{_ATTACK}</link>',
    "a property": f'<xacro:property name="p" value="{_ATTACK}"/><link name="${{p}}"/>',
    "a property at once": f'<xacro:property name="p" value="{_ATTACK}" lazy_eval="false"/>',
    "a global property": f'<xacro:property name="p" value="{_ATTACK}" scope="global"/>',
    "a property's default": f'<xacro:property name="p" default="{_ATTACK}"/><link name="${{p}}"/>',
    "a property's name": f'<xacro:property name="{_ATTACK}" value="1"/>',
    "a property's removal": f'<xacro:property name="p" remove="{_ATTACK}"/>',
    "an argument's default": f'<xacro:arg name="a" default="{_ATTACK}"/>',
    "a condition": f'<xacro:if value="{_ATTACK}"><link/></xacro:if>',
    "its opposite": f'<xacro:unless value="{_ATTACK}"><link/></xacro:unless>',
    "an include": f'<xacro:include filename="{_ATTACK}"/>',
    "an include's namespace": f'<xacro:include filename="part.xacro" ns="{_ATTACK}"/>',
    "a macro's default": f'<xacro:macro name="m" params="a:={_ATTACK}"/><xacro:m/><link/>',
    "a macro's argument": f'<xacro:macro name="m" params="a"/><xacro:m a="{_ATTACK}"/><link/>',
    "a macro's body": f'<xacro:macro name="m" params=""><link name="{_ATTACK}"/></xacro:macro><xacro:m/>',
    "a macro's call": f'<xacro:call macro="{_ATTACK}"/>',
    "a block": f'<xacro:macro name="m" params="*b"/><xacro:m><x y="{_ATTACK}"/></xacro:m>',
    "an element's name": f'<xacro:element xacro:name="{_ATTACK}"/>',
    "an attribute": f'<link><xacro:attribute name="n" value="{_ATTACK}"/></link>',
}


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


@pytest.mark.parametrize("name", matrix(list(EXPRESSIONS), 5))
def test_a_malicious_expression_is_refused(place, name):
    assert_refused(place, f'<link name="${{{escape(EXPRESSIONS[name])}}}"/>')


@pytest.mark.parametrize("name", matrix(list(SUBSTITUTIONS), 3))
def test_a_malicious_substitution_is_refused(place, name):
    assert_refused(place, f'<link name="{SUBSTITUTIONS[name]}"/>')


@pytest.mark.parametrize("name", matrix(list(DOCUMENTS), 5))
def test_a_malicious_document_is_refused(place, name):
    assert_refused(place, DOCUMENTS[name])


@pytest.mark.parametrize("name", matrix(list(PLACES), 5))
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


@pytest.mark.process
@pytest.mark.parametrize("attack", [OPENS_BY_FRAMES, RUNS_BY_FRAMES, READS_BY_FRAMES])
def test_the_attacks_succeed_with_the_package_xacro(place, attack):
    text = f'<robot {NAMESPACE}><link name="${{{escape(armed(attack, place))}}}"/></robot>'
    done = subprocess.run([sys.executable, "-c", PLAIN_XACRO], input=text, capture_output=True, text=True, check=True)
    assert (place / "mark").exists() or CANARY in done.stdout


@pytest.mark.process
@pytest.mark.parametrize("place_of_it", PLACES)
def test_the_package_xacro_evaluates_in_each_of_these_places(place, place_of_it):
    body = PLACES[place_of_it].replace("ATTACK", escape(armed(OPENS_BY_FRAMES, place)))
    text = f"<robot {NAMESPACE}>{body}</robot>"
    subprocess.run([sys.executable, "-c", PLAIN_XACRO], input=text, capture_output=True, text=True, check=False, cwd=place / "in")
    assert (place / "mark").exists()
