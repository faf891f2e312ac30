"""Entries of dynamics (``engine.entries``), which Python calls."""

from typing import TYPE_CHECKING

from ulna.engine.entries import modules_of

if not TYPE_CHECKING:  # tools find the modules beside this file
    __getattr__ = modules_of(__name__)
