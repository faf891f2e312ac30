"""Names the entries of q."""

from ulna.kinematics.tree import Tree


def entry_names(tree: Tree) -> tuple[str, ...]:
    """A name for every entry of q: the joint's, with a number behind it where a joint has several."""
    parts = [(name, range(tree.n_dof)[cut]) for name, cut in zip(tree.joint_names, tree.joint_slices, strict=True)]
    return tuple(f"{name}[{k}]" if len(cut) > 1 else name for name, cut in parts for k in range(len(cut)))
