"""Fuzzes the readers of URDF, SRDF and xacro, guided by coverage: they may raise nothing but an UlnaError.

    pip install atheris
    python tests/fuzz_readers.py -max_total_time=600 -timeout=30 -rss_limit_mb=2048

xacro runs in a child process, where coverage does not see it. So documents that use xacro are expanded one time in 200.
"""

import sys
import warnings

import atheris

with atheris.instrument_imports(include=["ulna.description", "ulna.description", "ulna.errors", "ulna.robot"]):
    import ulna
    from ulna.description import document

ROBOT = (
    '<robot name="r"><link name="a"/><link name="b"/>'
    '<joint name="c" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
)
WORDS = b"""robot link joint parent child origin axis limit mimic safety_controller visual collision geometry box sphere cylinder
    capsule mesh material color group chain group_state end_effector disable_collisions virtual_joint passive_joint name type xyz
    rpy size radius length filename scale rgba lower upper velocity effort multiplier offset k_velocity base_link tip_link
    parent_link value link1 link2 revolute continuous fixed prismatic planar floating xmlns:xacro="http://www.ros.org/wiki/xacro"
    xacro:macro xacro:include ${ }""".split()
seen = {"xacro": 0}
is_xacro = document.is_xacro


def now_and_then(root) -> bool:
    """To start a process takes a thousand times what reading takes."""
    if not is_xacro(root):
        return False
    seen["xacro"] += 1
    return seen["xacro"] % 200 == 0


def one(data: bytes) -> None:
    """A few bytes choose the reader; the rest is the document, plain or woven of the words of the formats."""
    provider = atheris.FuzzedDataProvider(data)
    which, woven = provider.ConsumeIntInRange(0, 1), provider.ConsumeBool()
    text = weave(provider) if woven else provider.ConsumeUnicodeNoSurrogates(sys.maxsize)
    try:
        robot = ulna.load("<" + text) if which == 0 else ulna.load(ROBOT, srdf="<" + text)
        len(robot.groups), len(robot.named_configurations), robot.to_urdf()
    except ulna.UlnaError as error:
        if len(str(error)) > 2000:
            raise AssertionError("a message without end") from error


def weave(provider) -> str:
    """Elements of known words with known attributes, nested at random."""
    text, waiting = 'robot name="r">', ["robot"]
    while provider.remaining_bytes() and len(text) < 20_000:
        tag = provider.PickValueInList(WORDS).decode()
        for _ in range(provider.ConsumeIntInRange(0, 3)):
            value = provider.ConsumeUnicodeNoSurrogates(provider.ConsumeIntInRange(0, 8)).replace('"', "")
            value = provider.PickValueInList(["a", "b", "c", "revolute", "fixed", "0 0 1", value])
            tag += f' {provider.PickValueInList(WORDS).decode()}="{value}"'
        if provider.ConsumeBool():
            text += f"<{tag}>"
            waiting.append(tag.split()[0])
        else:
            text += f"<{tag}/>"
        if provider.ConsumeBool() and len(waiting) > 1:
            text += f"</{waiting.pop()}>"
    return text + "".join(f"</{tag}>" for tag in reversed(waiting))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    document.is_xacro = now_and_then
    atheris.Setup(sys.argv, one)
    atheris.Fuzz()
