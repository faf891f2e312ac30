"""Entries (``engine.entries``) of the search for a path, its shortening, and its time parameterization."""

from typing import TYPE_CHECKING

from ulna.engine.entries import modules_of

COMPILED_TOGETHER = True  # they share collision checks in lanes, which take longest to compile
if not TYPE_CHECKING:  # tools find the modules beside this file
    __getattr__ = modules_of(__name__)
