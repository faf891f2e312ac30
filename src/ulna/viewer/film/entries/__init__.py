"""Entries of the renderer: the compiled functions that Python calls (``engine.entries``)."""

from typing import TYPE_CHECKING

from ulna.engine.entries import modules_of

if not TYPE_CHECKING:  # tools find the modules beside this file
    __getattr__ = modules_of(__name__)
