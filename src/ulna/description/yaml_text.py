"""Reads YAML from an untrusted source, with limits checked before values are constructed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ulna.errors import cited

_MAX_NODES = 20_000  # mappings, lists and scalars, each counted as often as an alias repeats it
_MAX_LEVELS = 50  # of nesting
_MAX_DIGITS = 40  # of a number: more than any needs
_PREFIX = "tag:yaml.org,2002:"
_KNOWN = {_PREFIX + kind for kind in ("map", "seq", "str", "int", "float", "bool", "null", "merge")}
_NUMBERS = {_PREFIX + "int", _PREFIX + "float"}


def yaml_value(text: str | bytes, tags: Mapping[str, Callable[[str], Any]], max_nodes: int = _MAX_NODES) -> Any:
    """The value of a YAML text with one document: dictionaries, lists, texts, numbers, booleans and None.

    Args:
        text: The text.
        tags: Further tags, with a function that makes a value of the text behind them.
        max_nodes: The maximum number of values, each counted as often as an alias repeats it.

    Raises:
        ValueError: It is not YAML, has other tags, dates, numbers in base 60, or too many nodes, levels or digits.
    """
    import yaml  # noqa: PLC0415 - few callers need it

    class Loader(yaml.SafeLoader):
        """PyYAML's safe loader, which checks each node as soon as it is read."""

        depth = n_nodes = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            self.depth += 1
            if self.depth > _MAX_LEVELS:
                raise ValueError(f"it has more than {_MAX_LEVELS} levels")
            is_alias = self.check_event(yaml.AliasEvent)
            node: Any = super().compose_node(parent, index)
            self.depth -= 1
            self.n_nodes += 1
            if is_alias and not hasattr(node, "weight"):
                raise ValueError("a value contains itself")
            node.weight = 1 + sum(one.weight for one in parts_of(node))  # its number of nodes, itself included
            if max(self.n_nodes, node.weight) > max_nodes:
                raise ValueError(f"it has more than {max_nodes} values, each counted as often as it is repeated")
            _check(node, tags)
            return node

    for tag, made in tags.items():
        Loader.add_constructor(tag, lambda loader, node, made=made: made(loader.construct_scalar(node)))  # pyright: ignore[reportArgumentType]
    try:
        return yaml.load(text, Loader)  # noqa: S506 - it is derived from the safe one
    except Exception as error:  # noqa: BLE001 - PyYAML raises AttributeError, KeyError, TypeError and others for odd tags
        raise ValueError(" ".join(str(error).split())[:300] or type(error).__name__) from None


def _check(node: Any, tags: Mapping[str, Any]) -> None:
    """Refuse an unknown tag, and a number that takes long to compute or is in base 60."""
    if node.tag not in tags and node.tag not in _KNOWN:
        raise ValueError(f"the tag {cited(node.tag.removeprefix(_PREFIX))} of {cited(node.value)} is not known")
    if node.tag not in _NUMBERS or not isinstance(node.value, str):
        return
    if len(node.value) > _MAX_DIGITS:
        raise ValueError(f"the number {cited(node.value)} has more than {_MAX_DIGITS} digits")
    if ":" in node.value:
        raise ValueError(f"the number {cited(node.value)} is in base 60; quotes make it a text")


def parts_of(node: Any) -> list[Any]:
    """The nodes in a node: keys and values of a mapping, members of a list."""
    if isinstance(node.value, str):
        return []
    return [part for one in node.value for part in (one if isinstance(one, tuple) else (one,))]
