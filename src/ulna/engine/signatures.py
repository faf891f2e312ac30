"""The types of the arguments of entries, as Numba's. Used by the drivers. All arrays are C-contiguous."""

from numba import types


def _array(element, dimensions: int, *, constant: bool = False) -> types.Array:
    return types.Array(element, dimensions, "C", readonly=constant)


WHOLE, NUMBER, NONE = types.int64, types.float64, types.none
NUMBERS, MATRIX, MATRICES, BLOCKS = (_array(types.float64, dimensions) for dimensions in (1, 2, 3, 4))
INDICES, INDEX_ROWS = _array(types.int64, 1), _array(types.int64, 2)
TRUTHS, TRUTH_ROWS = _array(types.boolean, 1), _array(types.boolean, 2)
# Pictures: the triangle behind each sample and its nearness, the light of each pixel, and its colours.
NUMBERED, NEARNESS, LIGHT, PIXELS = (
    _array(types.int32, 2), _array(types.float32, 2), _array(types.float32, 3), _array(types.uint8, 3),
)  # fmt: skip
SKIN = types.Tuple((MATRIX, MATRIX, NUMBERS, INDICES))
# A robot's tables, which are read-only.
CONSTANTS, TABLE = _array(types.float64, 1, constant=True), _array(types.float64, 2, constant=True)
PAIRS = _array(types.int64, 2, constant=True)
# The scene of ``overlap``: joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed. Where all shapes are boxes
# there are no vertices and no points. Robot and world have the same types, so that the kernels of two bodies are compiled once.
BOXES = TABLE, TABLE, NONE, PAIRS, TABLE, NONE, MATRIX, WHOLE
SHAPES = TABLE, TABLE, TABLE, PAIRS, TABLE, TABLE, MATRIX, WHOLE
SCENES = BOXES, SHAPES
