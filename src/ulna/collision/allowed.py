"""Holds pairs of links whose contact is no collision, each with a reason."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field

from ulna.description.arrays import as_number
from ulna.errors import InputError, UnknownNameError

ADJACENT = "adjacent"  # joined by one joint: they touch by design
FIXED = "fixed"  # joined by fixed joints only: they do not move relative to each other
ALWAYS = "always"  # in contact in every sampled configuration
SOMETIMES = "sometimes"  # in contact in some sampled configurations: checked
NEVER = "never"  # in contact in no sampled configuration: checked, unless the user allows the pair
USER = "user"  # given by the user
TOUCH_LINKS_HINT = "; for the links that may touch an object of a world: world.add(..., touch_links=[...])"


@dataclass(frozen=True)
class LinkPair:
    """Two links, in alphabetical order, and the reason why their contact is allowed or checked.

    Attributes:
        link_a: The link whose name comes first.
        link_b: The other link.
        reason: ``"adjacent"``, ``"fixed"``, ``"always"``, ``"sometimes"``, ``"never"``, ``"user"``, or a reason from an SRDF
            file.
        touched: The number of random configurations in which they touch.
        samples: The number of random configurations tried; 0 if none was needed.
        q: A configuration in which they touch; if none was found, one in which they do not touch [rad or m].

    Raises:
        InputError: Both names are the same.
    """

    link_a: str
    link_b: str
    reason: str = USER
    touched: int = 0
    samples: int = 0
    q: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.link_a == self.link_b:
            raise InputError("link_b", f"{self.link_b!r} is given for both links; two different links are expected")
        first, second = sorted((self.link_a, self.link_b))
        object.__setattr__(self, "link_a", first)
        object.__setattr__(self, "link_b", second)

    @property
    def links(self) -> frozenset[str]:
        """The two links as a set."""
        return frozenset((self.link_a, self.link_b))

    def __str__(self) -> str:
        seen = f" ({self.touched} of {self.samples})" if self.samples else ""
        return f"{self.link_a} - {self.link_b}: {self.reason}{seen}"


@dataclass(frozen=True)
class AllowedCollisions(Collection):
    """The pairs of links that may touch: a collection of ``LinkPair``; ``("a", "b") in allowed`` works too.

    Attributes:
        pairs: The allowed pairs.
        checked: The other sampled pairs of links with collision shapes. Some touched sometimes, some never; all are checked.

    Example:
        >>> import ulna
        >>> allowed = ulna.load("panda").allowed_collisions
        >>> ("panda_link5", "panda_link7") in allowed, ("panda_link1", "panda_link7") in allowed
        (True, False)
    """

    pairs: tuple[LinkPair, ...]
    checked: tuple[LinkPair, ...] = field(default=(), repr=False)

    def __contains__(self, pair: object) -> bool:
        links = pair.links if isinstance(pair, LinkPair) else frozenset(pair) if isinstance(pair, tuple | list | set) else None
        return any(links == known.links for known in self.pairs)

    def __iter__(self) -> Iterator[LinkPair]:
        return iter(self.pairs)

    def __len__(self) -> int:
        return len(self.pairs)

    @property
    def never_seen(self) -> tuple[LinkPair, ...]:
        """The pairs that touched in no sample. They are still checked: ``plus(*allowed.never_seen)`` allows them."""
        return tuple(pair for pair in self.checked if pair.reason == NEVER)

    def touching(self, share: float) -> tuple[LinkPair, ...]:
        """The checked pairs that touched in at least this share of the samples, above 0 and at most 1.

        Raises:
            InputError: The share is outside of this range.
        """
        share = as_number("touching", share, 0.0, "a share above 0 and at most 1", above=True, most=1.0)
        return tuple(pair for pair in self.checked if pair.samples and pair.touched >= share * pair.samples)

    def plus(self, *pairs: LinkPair | tuple[str, str]) -> "AllowedCollisions":
        """A copy with more pairs, each a ``LinkPair`` or two names.

        Raises:
            InputError: A pair is not the names of two different links.
        """
        added = as_link_pairs(pairs)
        new_sets = {pair.links for pair in added}
        unchanged = tuple(pair for pair in self.pairs if pair.links not in new_sets)
        return AllowedCollisions(unchanged + added, tuple(pair for pair in self.checked if pair.links not in new_sets))

    def minus(self, *pairs: LinkPair | tuple[str, str]) -> "AllowedCollisions":
        """A copy without some pairs, which are checked from then on.

        Raises:
            InputError: A pair is not the names of two different links.
            UnknownNameError: A pair is not an allowed pair.
        """
        removed = as_link_pairs(pairs)
        for pair in removed:
            if pair not in self:
                raise UnknownNameError("allowed pair", f"{pair.link_a} - {pair.link_b}", map(str, self.pairs))
        removed_sets = {pair.links for pair in removed}
        checked_again = tuple(pair for pair in self.pairs if pair.links in removed_sets)
        return AllowedCollisions(
            tuple(pair for pair in self.pairs if pair.links not in removed_sets), self.checked + checked_again
        )

    def to_srdf(self, robot: str) -> str:
        """SRDF text for the robot of this name, with a ``disable_collisions`` element for each pair."""
        from xml.sax.saxutils import quoteattr  # noqa: PLC0415 - it imports urllib.request

        rows = [map(quoteattr, (pair.link_a, pair.link_b, pair.reason.title())) for pair in self.pairs]
        lines = [f"  <disable_collisions link1={a} link2={b} reason={reason}/>" for a, b, reason in rows]
        return "\n".join(['<?xml version="1.0"?>', f"<robot name={quoteattr(robot)}>", *lines, "</robot>", ""])

    def __str__(self) -> str:
        return "\n".join(map(str, self.pairs)) or "no pair of links may touch"


def as_link_pairs(pairs: Iterable, name: str = "pairs") -> tuple[LinkPair, ...]:
    """The pairs as ``LinkPair``, without repeats. Input pairs are ``LinkPair``, two names, or pairs of an SRDF."""
    by_links: dict[frozenset[str], LinkPair] = {}
    for pair in pairs:
        links = (pair.link_a, pair.link_b) if hasattr(pair, "link_a") and hasattr(pair, "link_b") else pair
        if not (isinstance(links, tuple | list) and len(links) == 2 and all(isinstance(link, str) for link in links)):
            raise InputError(name, f"{pair!r}; the names of two links are expected")
        link_pair = pair if isinstance(pair, LinkPair) else LinkPair(*links, reason=(getattr(pair, "reason", "") or USER).lower())
        by_links[link_pair.links] = link_pair
    return tuple(by_links.values())


def as_allowed(allowed: Iterable, link_names: tuple[str, ...]) -> AllowedCollisions:
    """Allowed pairs from a user, after a check of their names."""
    if isinstance(allowed, str) or not isinstance(allowed, Iterable):
        raise InputError("allowed", f"{allowed!r}; pairs of links are expected, as robot.allowed_collisions.plus(...) makes them")
    collection = allowed if isinstance(allowed, AllowedCollisions) else AllowedCollisions(as_link_pairs(allowed, "allowed"))
    for pair in collection:
        for link in pair.links:
            if link not in link_names:
                raise UnknownNameError("link", link, link_names, TOUCH_LINKS_HINT)
    return collection
