"""Measures distances between configurations, and interpolates between them.

The metric is Euclidean, with a weight for each entry of q. For angles without limits the difference is the shorter turn.
``space`` has a record for each entry of q (``constraint_records.Entry``), shape (n_dof,).

A tree is stored in rows of eight nodes. Row ``block * n_dof + k`` has entry k of the nodes 8 block to 8 block + 7; it is infinite
in unused places.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, rint, splat, sqrt, where

INF = float("inf")


@kernel
def short_way(x, period):
    """The difference of an entry of q without whole turns, if it has a period."""
    if period > 0.0:
        return x - period * rint(x / period)
    return x


@kernel
def square_distance(tree_rows, block, q, space):
    """The squared distances of eight nodes of a tree from q, shape (n_dof,)."""
    n_dof = space.shape[0]
    total = splat(0.0, load(tree_rows, block * n_dof))
    for k in range(n_dof):
        x = short_way(load(tree_rows, block * n_dof + k) - q[k], space[k].period) * space[k].weight
        total = total + x * x
    return total


@kernel
def nearest_in_lanes(tree_rows, n_blocks, q, space):
    """The least squared distance of a tree's nodes from q in each lane, and its block.

    It is a linear scan: for the few thousand nodes of a tree, eight at a time, it takes less time than one certified edge.
    """
    least = square_distance(tree_rows, 0, q, space)
    at = splat(0.0, least)
    for block in range(1, n_blocks):
        square = square_distance(tree_rows, block, q, space)
        nearer = square < least
        least, at = where(nearer, square, least), where(nearer, splat(float(block), least), at)
    return least, at


@kernel
def nearest_below_in_lanes(tree_rows, cost_rows, n_blocks, q, bound, space):
    """``nearest_in_lanes`` among nodes whose cost plus distance from q is at most ``bound``; infinite without any."""
    least = splat(INF, load(cost_rows, 0))
    at = splat(0.0, least)
    for block in range(n_blocks):
        left = splat(bound, least) - load(cost_rows, block)
        square = square_distance(tree_rows, block, q, space)
        nearer = (left >= 0.0) & (square <= left * left) & (square < least)
        least, at = where(nearer, square, least), where(nearer, splat(float(block), least), at)
    return least, at


@kernel
def distance(a, b, space):
    """The distance between two configurations, shape (n_dof,) each."""
    total = 0.0
    for k in range(space.shape[0]):
        x = short_way(b[k] - a[k], space[k].period) * space[k].weight
        total += x * x
    return sqrt(total)


@kernel
def write_step(a, b, share, space, out):
    """Write the configuration at a share of the distance from a to b.

    A share of 1 gives exactly b, up to whole turns.
    """
    for k in range(space.shape[0]):
        way = short_way(b[k] - a[k], space[k].period)
        direct = share >= 1.0 and way == b[k] - a[k]
        out[k] = b[k] if direct else a[k] + share * way


@kernel
def adapted_domain(radius, settings, extended):
    """The radius of a node's dynamic domain after an extension (Jaillet, Yershova, LaValle and Simeon 2005).

    It is unlimited until the first failed extension. Then it shrinks with each failure and grows with each success.
    """
    if extended:
        return radius * (1.0 + settings.adaptation)
    if radius > settings.domain * 1e6:
        return min(radius, settings.domain)
    return max(settings.min_domain, radius * (1.0 - settings.adaptation))
