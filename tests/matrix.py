"""Marks all but a few of many similar cases: ``make test`` runs these few, ``make test-all`` every case."""

from collections.abc import Collection, Sequence
from typing import Any

import pytest


def matrix(cases: Sequence[Any], chosen: Collection[Any] | int) -> list[Any]:
    """The cases as parameters: all have the marker ``matrix`` but those that are chosen, or so many from first to last."""
    if isinstance(chosen, int):
        chosen = [cases[k * len(cases) // chosen] for k in range(chosen)]
    assert all(case in cases for case in chosen), f"{chosen} are to be some of {cases}"
    return [case if case in chosen else pytest.param(case, marks=pytest.mark.matrix) for case in cases]
