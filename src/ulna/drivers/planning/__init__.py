"""Drivers of planning: the search for a path between two trees, and its shortening."""

from typing import TYPE_CHECKING

from ulna.engine.entries import Entries

if not TYPE_CHECKING:  # as in ``ulna.drivers``
    __getattr__ = Entries(__name__).module
