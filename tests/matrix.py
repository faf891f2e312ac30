"""Cases of which ``make test`` runs a few, each of a kind of its own, and ``make test-all`` every one."""

from collections.abc import Collection, Sequence
from typing import Any

import pytest


def matrix(cases: Sequence[Any], chosen: Collection[Any]) -> list[Any]:
    """The cases as parameters: all have the marker ``matrix`` but those that are chosen."""
    assert set(chosen) <= set(cases), f"there is no case {set(chosen) - set(cases)}"
    return [case if case in chosen else pytest.param(case, marks=pytest.mark.matrix) for case in cases]
