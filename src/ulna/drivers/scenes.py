"""Declares the types of a scene, which entries take whole."""

from ulna.engine.signatures import MATRIX, NONE, PAIRS, TABLE, TRUTH_TABLE, WHOLE, Group
from ulna.kernels.collision.scene import Scene

# Robot and world have the same types, so that the kernels of two bodies are compiled once.
BOXES = Group((TABLE, TABLE, NONE, PAIRS, TABLE, NONE, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene)
SHAPES = Group((TABLE, TABLE, TABLE, PAIRS, TABLE, TABLE, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene)
SCENES = BOXES, SHAPES
