"""Invalid and malicious XML: refused with its line."""

from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError, UlnaError

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="hand">
    <visual><geometry><box size="1 1 1"/></geometry></visual>
  </link>
  <joint name="wrist" type="continuous">
    <parent link="base"/>
    <child link="hand"/>
  </joint>
</robot>
"""
FAULTS = {
    "an empty file": (b"", 1),
    "a file of blanks": (b" \n\n", 3),
    "not XML": (b"robot: arm\n", 1),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), 1),
    "zero bytes": (bytes(64), 1),
    "no end": (ARM.replace("</robot>", ""), 11),
    "a tag closed by another": (ARM.replace("</link>", "</lnk>"), 5),
    "an attribute given twice": (ARM.replace('name="base"', 'name="base" name="base"'), 2),
    "two documents in one": (ARM + ARM, 11),
    "an undeclared entity": (ARM.replace('name="base"', 'name="&base;"'), 2),
    "bytes that are not UTF-8": (ARM.encode().replace(b"wrist", b"wr\xefst"), 6),
    "UTF-16 without a mark": (ARM.encode("utf-16-le"), 1),
    "an unknown encoding": ('<?xml version="1.0" encoding="klingon"?>' + ARM, 1),
    "nesting without end": ("<robot>\n" + "<a>" * 100_000, 2),
    "an attribute of twenty megabytes": (ARM.replace('name="base"', f'name="{"b" * 20_000_000}"'), 2),
}
LAUGHS = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 10))
ENTITIES = {
    "a billion laughs": f'<!ENTITY e0 "ha">{LAUGHS}<!ENTITY base "&e9;">',
    "one small entity": '<!ENTITY base "base">',
    "a file": '<!ENTITY base SYSTEM "file:///etc/passwd">',
    "a parameter": '<!ENTITY % part "x"><!ENTITY base "base">',
}


def written(tmp_path: Path, document: str | bytes) -> Path:
    file = tmp_path / "arm.urdf"
    file.write_bytes(document if isinstance(document, bytes) else document.encode())
    return file


def test_the_document_without_a_fault_is_valid(tmp_path):
    assert ulna.load(written(tmp_path, ARM)).joint_names == ("wrist",)


@pytest.mark.parametrize("name", FAULTS)
def test_invalid_xml_is_refused_with_its_line(tmp_path, name):
    document, line = FAULTS[name]
    with pytest.raises(DescriptionError) as caught:
        ulna.load(written(tmp_path, document))
    assert str(caught.value).startswith(f"arm.urdf:{line}: not XML: ")
    assert (caught.value.source, caught.value.line) == ("arm.urdf", line)


@pytest.mark.parametrize("name", FAULTS)
def test_the_message_is_one_line_without_options_of_the_parser(tmp_path, name):
    with pytest.raises(DescriptionError) as caught:
        ulna.load(written(tmp_path, FAULTS[name][0]))
    assert "\n" not in str(caught.value)
    assert "XML_PARSE" not in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("place", ['name="base"', '<parent link="base"/>'], ids=["in a name", "between the tags"])
@pytest.mark.parametrize("name", ENTITIES)
def test_entities_are_refused_before_they_are_expanded(tmp_path, name, place, encoding):
    used = ARM.replace(place, place.replace("base", "&base;") if "name" in place else "&base;" + place)
    document = f'<?xml version="1.0" encoding="{encoding}"?>\n<!DOCTYPE robot [{ENTITIES[name]}]>\n{used}'
    with pytest.raises(DescriptionError, match=r"^arm\.urdf.*(?i:entit)"):
        ulna.load(written(tmp_path, document.encode(encoding)))


def test_an_external_document_type_is_not_read(tmp_path):
    (tmp_path / "names.dtd").write_text('<!ELEMENT robot ANY> <!ATTLIST robot name CDATA "from outside">')
    document = ARM.replace(' name="arm"', "")
    file = written(tmp_path, f'<!DOCTYPE robot SYSTEM "{(tmp_path / "names.dtd").as_uri()}">\n{document}')
    assert ulna.load(file).name == ""


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_a_declared_encoding_is_read(tmp_path, encoding):
    document = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?>\n' + ARM.replace("wrist", "poign\u00e9e")
    robot = ulna.load(written(tmp_path, document.encode(encoding)))
    assert robot.joint_names == ("poign\u00e9e",)
    assert "poign\u00e9e" in robot.to_urdf()


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_needs_no_declaration(tmp_path, encoding):
    assert ulna.load(written(tmp_path, ARM.encode(encoding))).joint_names == ("wrist",)


@pytest.mark.parametrize("encoding", ["ARMSCII-8", "EUC-TW"])
def test_an_encoding_that_python_lacks_raises_no_lookup_error(tmp_path, encoding):
    file = written(tmp_path, f'<?xml version="1.0" encoding="{encoding}"?>\n{ARM}')
    try:
        assert ulna.load(file).joint_names == ("wrist",)
    except UlnaError as error:
        assert encoding in str(error)  # noqa: PT017


def test_the_declared_encoding_of_a_string_is_ignored():
    document = '<?xml version="1.0" encoding="iso-8859-1"?>\n' + ARM.replace("wrist", "poign\u00e9e")
    assert ulna.load(document).joint_names == ("poign\u00e9e",)


def test_a_processing_instruction_in_a_geometry_is_ignored():
    robot = ulna.load(ARM.replace('<box size="1 1 1"/>', '<?editor fold?><box size="1 1 1"/>'))
    assert robot.description.links[1].visuals[0].shape == ulna.Box((1, 1, 1))


def test_comments_and_elements_of_other_programs_are_ignored():
    extra = '<transmission name="t"><joint name="wrist"/></transmission><gazebo reference="hand"><mu1>0.2</mu1></gazebo>'
    robot = ulna.load(
        ARM.replace("</robot>", f"<!-- {extra} -->{extra}</robot>").replace("<geometry>", "<geometry><!-- a box -->")
    )
    assert robot.joint_names == ("wrist",)
    assert robot.link_names == ("base", "hand")


@pytest.mark.parametrize("declared", ['xmlns="http://www.ros.org"', 'xmlns="http://www.ros.org" xmlns:gazebo="http://other"'])
def test_a_default_namespace_is_accepted(declared):
    robot = ulna.load(ARM.replace("<robot ", f"<robot {declared} "))
    assert (robot.joint_names, robot.description.joints[0].line) == (("wrist",), 6)
    srdf = f'<robot name="arm" {declared}><group name="g"><joint name="wrist"/></group></robot>'
    assert ulna.load(ARM, srdf=srdf).groups["g"].joint_names == ("wrist",)


def test_elements_of_another_namespace_are_ignored():
    extra = '<other:link xmlns:other="http://other" name="extra"/></robot>'
    assert ulna.load(ARM.replace("</robot>", extra)).link_names == ("base", "hand")
