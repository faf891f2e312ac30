"""Drivers of a servo: one entry, which computes one tick."""

from typing import TYPE_CHECKING

from ulna.engine.entries import Entries

if not TYPE_CHECKING:  # as in ``ulna.drivers``
    __getattr__ = Entries(__name__).module
