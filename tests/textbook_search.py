"""Runs a textbook search by its entry, with all its arrays made here."""

import numpy as np

from ulna.drivers import single_start
from ulna.kernels.ik import search_layout as layout

follow_each = single_start.follow_each


def search(method, tree, link, seeds, targets, steps=10_000, tolerance=1e-5, *, trace=False):
    """q and the information of every target, and the trace."""
    settings = np.zeros(layout.N_SETTINGS)
    settings[layout.POSITION_TOLERANCE] = settings[layout.ROTATION_TOLERANCE] = tolerance
    settings[layout.STEPS] = steps
    bounds = np.array([[tree.lower, tree.upper, tree.lower, tree.upper]])
    q, info = np.full(seeds.shape, np.nan), np.full((len(targets), layout.N_INFO), np.nan)
    history = np.full((steps + 1 if trace else 0, 4), np.nan)
    with np.errstate(all="ignore"):
        follow_each(method, tree.chain(link), targets, np.array(seeds), bounds, settings, q, info, history)
    return (q, info, history) if trace else (q, info)
