"""Documents of extreme size: loaded or refused, in bounded time and memory.

No time is asserted, but an algorithm of quadratic or cubic cost would exceed the limit of 300 s of a test.
"""

from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna import DescriptionError, UlnaError
from ulna.description.xacro import expansion as xacro
from ulna.description.xml import LONGEST, MAX_ELEMENTS

JOINT = '<joint name="j{0}" type="{2}"><parent link="l{0}"/><child link="l{1}"/>{3}</joint>'
LIMIT = '<limit lower="-1" upper="1"/>'


def links(n: int) -> str:
    return "".join(f'<link name="l{k}"/>' for k in range(n))


def chain(n: int, kind: str = "fixed", more: str = "") -> str:
    return "".join(JOINT.format(k, k + 1, kind, more.format(k + 1)) for k in range(n))


def robot(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def test_a_million_links_are_refused():
    text = robot('<link name="l"/>' * 1_000_000)
    with pytest.raises(DescriptionError, match=rf"^URDF text: has 1000001 elements; up to {MAX_ELEMENTS} are read$"):
        ulna.load(text)


@pytest.mark.parametrize("kind", ["URDF", "SRDF"])
def test_an_endless_document_is_read_up_to_a_limit(kind):
    """/dev/zero is endless."""
    if not Path("/dev/zero").exists():
        return
    with pytest.raises(DescriptionError, match=rf"^zero: is {LONGEST / 1e6:.0f} MB long; up to {LONGEST / 1e6:.0f} MB are read$"):
        ulna.load(*(("/dev/zero",) if kind == "URDF" else ("panda",)), **({} if kind == "URDF" else {"srdf": "/dev/zero"}))


def test_a_chain_of_four_thousand_links_and_a_part_of_it_can_be_loaded():
    n = 4_000
    whole = ulna.load(robot(links(n + 1), chain(n, more='<origin xyz="0 0 1e-3"/>')))
    np.testing.assert_allclose(whole.forward_kinematics([])[2, 3], n * 1e-3, rtol=1e-9)
    assert len(ulna.load(whole.to_urdf(), base=f"l{n // 2}").link_names) == n // 2 + 1


@pytest.mark.slow
def test_ten_thousand_nested_mimics_are_resolved():
    n = 10_000
    followers = chain(n - 1, "continuous", '<mimic joint="j{0}" multiplier="1"/>')
    whole = ulna.load(robot(links(n + 1), followers, JOINT.format(n - 1, n, "continuous", "")))
    assert whole.joint_names == (f"j{n - 1}",)
    assert whole.jacobian([0.0], link=f"l{n}")[3, 0] == n


def test_the_error_for_a_cycle_of_mimics_is_short():
    n = 2_000
    text = robot(
        links(n + 1),
        chain(n - 1, "continuous", '<mimic joint="j{0}"/>'),
        JOINT.format(n - 1, n, "continuous", '<mimic joint="j0"/>'),
    )
    with pytest.raises(
        DescriptionError, match=r"^URDF text:1: joints j0 -> j1 -> j2 -> j3 -> \.\.\. -> .* -> j0 mimic each other in a circle$"
    ):
        ulna.load(text)


def test_a_large_loop_of_joints_is_refused():
    n = 10_000
    with pytest.raises(DescriptionError, match="joint 'j0' is part of a loop of joints that the root does not reach"):
        ulna.load(robot('<link name="root"/>', links(n), chain(n - 1), JOINT.format(n - 1, 0, "fixed", "")))


@pytest.mark.parametrize("text", ["0" * 1_000_000, "1" * 1_000_000, "9" * 400 + " 0 0", "1e308 1e308 1e308", "-0x" * 100_000])
def test_huge_numbers_are_loaded_or_refused_in_a_short_message(text):
    joint = '<joint name="j" type="fixed"><origin xyz="{0}"/><parent link="l0"/><child link="l1"/></joint>'
    with pytest.raises(UlnaError) as caught:
        ulna.load(robot(links(2), joint.format(text))).link_poses([])
    assert len(str(caught.value)) < 1200


def test_names_of_a_megabyte_are_shortened_in_the_message():
    name = "ab" * 500_000
    with pytest.raises(DescriptionError, match=r"^URDF text:1: joint 'j': parent link 'abab.* \.\.\. ") as caught:
        ulna.load(
            robot(
                f'<link name="{name}x"/><link name="b"/>',
                f'<joint name="j" type="fixed"><parent link="{name}y"/><child link="b"/></joint>',
            )
        )
    assert len(str(caught.value)) < 1200


@pytest.mark.slow
def test_nested_groups_of_an_srdf_are_limited():
    groups = (
        "".join(f'<group name="g{k}"><group name="g{k + 1}"/></group>' for k in range(1999))
        + '<group name="g1999"><joint name="panda_joint1"/></group>'
    )
    panda = ulna.load("panda", srdf=f'<robot name="r">{groups}</robot>')
    assert all(group.columns == (0,) for group in panda.groups.values())
    with pytest.raises(DescriptionError, match="has more than 2000 <group>"):
        ulna.load("panda", srdf=f'<robot name="r">{groups}<group name="one"/></robot>')


def test_disabled_default_collisions_of_an_srdf_are_limited():
    n = 1_500
    alone = "".join(f'<disable_default_collisions link="l{k}"/>' for k in range(n))
    with pytest.raises(DescriptionError, match="disables the collisions of 1500 links with 1501"):
        ulna.load(robot(links(n + 1), chain(n)), srdf=robot(alone))


def test_a_xacro_file_with_a_huge_expansion_is_refused(tmp_path):
    (tmp_path / "r.xacro").write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="${\'a\' * 100000000}"/></robot>'
    )
    with pytest.raises(DescriptionError, match=r"expands to 100 MB; up to 64 MB are read$"):
        ulna.load(tmp_path / "r.xacro")


@pytest.mark.parametrize("default", ["a" * 1000 + "'", "'" * 1001, "${" * 1000])
def test_a_long_default_of_a_macro_is_read_in_linear_time(default, monkeypatch):
    monkeypatch.setattr(xacro, "TIME_LIMIT_S", 2)  # in the process of its own, the package xacro tries again and again
    macro = f'<xacro:macro name="m" params="p:={default}"><link name="a"/></xacro:macro>'
    with pytest.raises(
        DescriptionError, match=r"only defines the macro 'm'; to call it|not finished within 2 s|invalid|expression"
    ):
        ulna.load(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{macro}</robot>')


def test_a_long_package_xml_without_a_name_is_read_in_linear_time(tmp_path):
    (tmp_path / "package.xml").write_text("<name>" + " " * 900_000)
    file = tmp_path / "r.xacro"
    file.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="$(find other)/x"/></robot>'
    )
    with pytest.raises(DescriptionError, match="no such package"):
        ulna.load(file)
