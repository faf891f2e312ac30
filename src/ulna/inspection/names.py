"""Checks names: defined twice, differing by case only, or undefined. Used by ``inspect``."""

from collections.abc import Iterator

from lxml import etree

from ulna.errors import did_you_mean
from ulna.inspection.elements import of_robot
from ulna.inspection.result import Finding, Severity


def name_findings(root: etree._Element) -> Iterator[Finding]:
    """What is wrong with the names of links and joints, and with what refers to them."""
    for tag in ("link", "joint"):
        yield from _repeated(root, tag)
    links = {element.get("name", "") for element in root.iterfind("link")}
    joints = {element.get("name", "") for element in root.iterfind("joint")}
    for joint in root.iterfind("joint"):
        for tag, key, known in (("parent", "link", links), ("child", "link", links), ("mimic", "joint", joints)):
            name = "" if (element := joint.find(tag)) is None else element.get(key, "")
            if element is not None and name not in known:
                message = f"<{tag}> {key} {name!r} is not defined{did_you_mean(name, known)}"
                yield Finding(Severity.ERROR, of_robot(joint), message, joint.sourceline)


def _repeated(root: etree._Element, tag: str) -> Iterator[Finding]:
    exact: set[str] = set()
    folded: dict[str, str] = {}
    for element in root.iterfind(tag):
        name, where = element.get("name", ""), of_robot(element)
        if not name:
            yield Finding(Severity.ERROR, where, f"a <{tag}> without a name", element.sourceline)
        elif name in exact:
            yield Finding(Severity.ERROR, where, "defined twice", element.sourceline)
        elif name.casefold() in folded:
            message = f"differs from {folded[name.casefold()]!r} by case only"
            yield Finding(Severity.WARNING, where, message, element.sourceline)
        exact.add(name)
        folded.setdefault(name.casefold(), name)
