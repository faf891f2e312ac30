"""Documents at random: whatever the readers of URDF, SRDF and xacro are given, nothing but a robot or an UlnaError comes out.

``tests/fuzz_readers.py`` does the same for as long as one likes, led by coverage.
"""

import itertools
import pickle
import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ulna
from robot_files import example_srdfs
from ulna import UlnaError

SRDF = next(file for file in example_srdfs() if file.stem == "panda").read_text().replace("panda_hand", "panda_ee")
XACRO = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="n" default="2"/><xacro:property name="w" value="${0.5 * 2}"/>
  <xacro:macro name="part" params="name:=a *inner"><link name="${name}"><xacro:insert_block name="inner"/></link></xacro:macro>
  <xacro:part name="base"><visual><geometry><box size="1 ${w} $(arg n)"/></geometry></visual></xacro:part>
  <xacro:if value="${w > 0}"><link name="tip"/></xacro:if>
  <joint name="j" type="continuous"><parent link="base"/><child link="tip"/></joint>
</robot>"""
SPLINTERS = [
    "",
    "nan",
    "-1",
    "1e999",
    "0 0 0",
    "${x}",
    "$(arg x)",
    "${",
    "<",
    ">",
    '"',
    "/>",
    "&amp;",
    "<!-- ",
    "<?x?>",
    "\0",
    "<link/>",
    "panda",
]
splinters = st.one_of(st.sampled_from(SPLINTERS), st.text(max_size=8))
# ---- trees of the words of both formats, put together without sense
TAGS = """robot link joint parent child origin axis limit mimic safety_controller visual collision geometry box sphere cylinder
    capsule mesh material color group chain group_state end_effector disable_collisions virtual_joint passive_joint
    disable_default_collisions""".split()  # noqa: SIM905
KEYS = """name link type xyz rpy size radius length filename scale rgba lower upper velocity effort joint multiplier offset
    k_velocity soft_lower_limit soft_upper_limit base_link tip_link parent_link group value link1 link2 child_link
    parent_frame""".split()  # noqa: SIM905
TYPES = ["revolute", "fixed", "floating", "planar", "continuous", "prismatic"]
VALUES = [*"abc", *TYPES, "0", "1", "-1", "1 2 3", "0 0 0", "1e300", "inf", ""]
attributes = st.dictionaries(st.sampled_from(KEYS), st.one_of(st.sampled_from(VALUES), st.floats().map(str)), max_size=4)


def element(tag: str, given: dict[str, str], children: list[str]) -> str:
    words = "".join(f' {key}="{value}"' for key, value in given.items())
    return f"<{tag}{words}>{''.join(children)}</{tag}>"


elements = st.recursive(
    st.builds(element, st.sampled_from(TAGS), attributes, st.just([])),
    lambda inner: st.builds(element, st.sampled_from(TAGS), attributes, st.lists(inner, max_size=4)),
    max_leaves=12,
)
named_links = st.sets(st.sampled_from("abc")).map(lambda names: [f'<link name="{name}"/>' for name in sorted(names)])
joints = st.builds(
    lambda name, kind, parent, child, inner: element(
        "joint", {"name": name, "type": kind}, [f'<parent link="{parent}"/><child link="{child}"/>', *inner]
    ),
    *(st.sampled_from(values) for values in ("xyz", TYPES, "abc", "abc")),
    st.lists(elements, max_size=3),
)
trees = st.builds(
    lambda *parts: f'<robot name="r">{"".join(itertools.chain(*parts))}</robot>',
    named_links,
    st.lists(joints, max_size=3),
    st.lists(elements, max_size=5),
)


def use(urdf: str, srdf: str | None = None) -> None:
    """Load, and ask for all that is worked out late. Anything but an UlnaError fails the test."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            robot = ulna.load(urdf, srdf=srdf)
        for q in (robot.home, *robot.named_configurations.values()):
            assert q.shape == (robot.n_dof,)
        poses = robot.link_poses(robot.home)
        assert all(set(group.link_names) <= set(robot.link_names) for group in robot.groups.values())
        twin = pickle.loads(pickle.dumps(robot))  # noqa: S301
        assert np.array_equal(twin.link_poses(twin.home), poses)
    except UlnaError as error:
        assert str(error)  # noqa: PT017


@pytest.mark.slow
@settings(max_examples=150)
@given(trees)
def test_words_of_urdf_without_sense_are_a_robot_or_an_ulna_error(text):
    use(text)


@pytest.mark.slow
@settings(max_examples=150)
@given(st.lists(elements, max_size=6))
def test_words_of_srdf_without_sense_are_a_robot_or_an_ulna_error(parts):
    joint = '<joint name="c" type="continuous"><parent link="a"/><child link="b"/></joint>'
    urdf, srdf = (f'<robot name="r">{inner}</robot>' for inner in (f'<link name="a"/><link name="b"/>{joint}', "".join(parts)))
    use(urdf, srdf)


@settings(max_examples=150)
@given(st.integers(0, len(SRDF)), st.integers(0, 300), splinters)
def test_a_damaged_srdf_is_a_robot_or_an_ulna_error(start, length, splinter):
    use("panda", (SRDF[:start] + splinter + SRDF[start + length :]).strip() or "<")


@settings(max_examples=12)
@given(st.integers(0, len(XACRO)), st.integers(0, 30), splinters)
def test_a_damaged_xacro_file_is_a_robot_or_an_ulna_error(start, length, splinter):
    use("<" + (XACRO[:start] + splinter + XACRO[start + length :]).lstrip("<"))


EXPRESSIONS = [m.span(1) for m in re.finditer(r'="([^"]*[$][^"]*)"', XACRO)]


@settings(max_examples=12)
@given(st.sampled_from(EXPRESSIONS), st.text(alphabet="w0.5*/-+()[]{}'$ <>=nxyz_,:", max_size=12))
def test_expressions_at_random_are_a_robot_or_an_ulna_error(span, expression):
    use(XACRO[: span[0]] + "${" + expression.replace("<", "&lt;") + "}" + XACRO[span[1] :])
