"""Robots with two arms: five joints each on a turning post, made of boxes, with an SRDF; and two Pandas."""

from itertools import pairwise

import numpy as np

LIMIT = '<limit lower="-3" upper="3" velocity="2" effort="1"/>'
BOX = '<collision name="{0}"><origin xyz="{1}"/><geometry><box size="{2}"/></geometry></collision>'
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0")  # of the joints of an arm, from the shoulder on
LENGTHS = (0.1, 0.3, 0.3, 0.1, 0.15)  # of the links behind them


def _arm(side: str, y: float) -> str:
    links = ["post", *(f"{side}_{k}" for k in range(1, 6)), f"{side}_hand"]
    text = "".join(
        f'<link name="{link}">{BOX.format(link, f"{length / 2} 0 0", f"{length - 0.02} 0.06 0.06")}</link>'
        for link, length in zip(links[1:-1], LENGTHS, strict=True)
    )
    places = [f"0.1 {y} 0.6", *(f"{length} 0 0" for length in LENGTHS)]
    for k, ((parent, child), place) in enumerate(zip(pairwise(links), places, strict=True), start=1):
        body = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{place}"/>'
        kind, rest = ("fixed", "") if child.endswith("hand") else ("revolute", f'<axis xyz="{AXES[k - 1]}"/>{LIMIT}')
        text += f'<joint name="{side}_joint{k}" type="{kind}">{body}{rest}</joint>'
    return text + f'<link name="{side}_hand"/>'


URDF = (
    '<robot name="two arms"><link name="floor"/><link name="post">'
    + BOX.format("post", "0 0 0.3", "0.1 0.1 0.6")
    + '</link><joint name="torso" type="revolute"><parent link="floor"/><child link="post"/><axis xyz="0 0 1"/>'
    + LIMIT
    + f"</joint>{_arm('left', 0.2)}{_arm('right', -0.2)}</robot>"
)
SRDF = """<robot name="two arms">
  <group name="left_arm"><chain base_link="post" tip_link="left_hand"/></group>
  <group name="right_arm"><chain base_link="post" tip_link="right_hand"/></group>
  <group name="both_arms"><group name="left_arm"/><group name="right_arm"/></group>
  <group name="hands"><link name="floor"/></group>
  <group_state name="up" group="left_arm">
    <joint name="left_joint2" value="-1.2"/><joint name="left_joint3" value="0.4"/></group_state>
</robot>"""


def assert_arrives(robot, plan, goal):
    """The plan is certified, free at 5001 samples, and ends with each link at its pose."""
    assert plan, str(plan)
    assert plan.certified
    assert not robot.in_collision(plan.at(np.linspace(0, 1, 5001))).any()
    for link, T in goal.items():
        assert np.allclose(robot.forward_kinematics(plan.path[-1], link=link), T, atol=2e-5)


def two_pandas(panda, *, waist: bool) -> str:
    """The URDF of two Pandas on a chest, which turns about a waist or is fixed: 15 joints or 14."""
    text = panda.to_urdf()
    text = text[text.index("<link") : text.index("</robot>")]
    arms = ""
    for side, y, turn in (("left", 0.25, -0.3), ("right", -0.25, 0.3)):
        place = f'<parent link="chest"/><child link="{side}_link0"/><origin xyz="0 {y} 0.2" rpy="{turn} 0 0"/>'
        arms += text.replace('"panda_', f'"{side}_') + f'<joint name="{side}_mount" type="fixed">{place}</joint>'
    solid = '<collision><geometry><box size="0.2 0.3 0.3"/></geometry></collision>'
    kind = "revolute" if waist else "fixed"
    joint = f'<joint name="waist" type="{kind}"><parent link="pelvis"/><child link="chest"/><origin xyz="0 0 0.5"/>'
    joint += '<axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5" velocity="1.5" effort="1"/></joint>'
    return f'<robot name="cell"><link name="pelvis"/><link name="chest">{solid}</link>{joint}{arms}</robot>'
