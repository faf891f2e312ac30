"""Forward kinematics: where the links are."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.kernels.chain import forward_batch, forward_one
from ulna.kernels.tree import frames_batch, frames_one
from ulna.kinematics.positions import as_positions, flat, for_kernel, refuse_out_of_range
from ulna.model.tree import Tree


def forward_kinematics(tree: Tree, q: ArrayLike, link: str) -> NDArray[np.float64]:
    """T_base_link, shape (..., 4, 4), for q of shape (..., n_dof)."""
    chain = tree.chain(link)
    q = as_positions(q, tree)
    if q.ndim == 1:
        T = np.empty((4, 4))
        good = forward_one(chain, q if tree.n_dof else for_kernel(q), T)
    else:
        T = np.empty((*q.shape[:-1], 4, 4))
        good = forward_batch(chain, flat(q), T.reshape(-1, 4, 4))
    if not good:
        refuse_out_of_range(q)
    return T


def frame_poses(tree: Tree, frames: NDArray[np.float64], q: ArrayLike) -> NDArray[np.float64]:
    """T_base_frame of every row of a table of frames, shape (..., n_frames, 4, 4), for q of shape (..., n_dof)."""
    q = as_positions(q, tree)
    if q.ndim == 1:
        T = np.empty((len(frames), 4, 4))
        good = frames_one(tree.joints, frames, q if tree.n_dof else for_kernel(q), T)
    else:
        T = np.empty((*q.shape[:-1], len(frames), 4, 4))
        good = frames_batch(tree.joints, frames, flat(q), T.reshape(-1, len(frames), 4, 4))
    if not good:
        refuse_out_of_range(q)
    return T
