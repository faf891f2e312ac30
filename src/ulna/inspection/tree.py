"""Lists the links of a description depth first, even if its joints form no tree. Used by ``inspect``."""

from collections import defaultdict

from lxml import etree

from ulna.inspection.result import TreeRow


def tree_rows(root: etree._Element) -> tuple[TreeRow, ...]:
    """A row for each link: from the links without a parent down, each link once, and then what only loops reach."""
    links = [link.get("name", "") for link in root.iterfind("link")]
    carried: defaultdict[str, list[TreeRow]] = defaultdict(list)
    for joint in root.iterfind("joint"):
        parent, child = (_link(joint, key) for key in ("parent", "child"))
        carried[parent].append(TreeRow(0, child, joint.get("name", ""), joint.get("type", "")))
    children = {row.link for rows in carried.values() for row in rows}
    rows: list[TreeRow] = []
    seen: set[str] = set()
    for start in [*(link for link in links if link not in children), *links]:
        waiting = [TreeRow(0, start)] if start not in seen else []
        while waiting:
            row = waiting.pop()
            rows.append(row)
            if row.link not in seen:
                seen.add(row.link)
                waiting += [TreeRow(row.depth + 1, one.link, one.joint, one.type) for one in reversed(carried[row.link])]
    return tuple(rows)


def _link(joint: etree._Element, key: str) -> str:
    element = joint.find(key)
    return "" if element is None else element.get("link", "")
