"""Entries of the search for a path, its shortening, and its time parameterization: what Python calls (``engine.entries``)."""

from typing import TYPE_CHECKING

from ulna.engine.entries import modules_of

COMPILED_TOGETHER = True  # they call the distance or the overlap of two bodies in lanes, which takes longest to compile
if not TYPE_CHECKING:  # tools find the modules beside this file
    __getattr__ = modules_of(__name__)
