"""Names the parts of the branches of a closed form as its kernels pass them on."""

from typing import Any, NamedTuple


class Branches(NamedTuple):
    """The rows of all branches, which the caller owns (``closed_form.closed_form``)."""

    sign_rows: Any
    """3 n."""
    n: int
    """Number of signs of each of three choices."""
    free_rows: Any
    """Twelve: sines and cosines of what angles are to be where any would do."""
    q_rows: Any
    """Six a branch, written."""
    known_rows: Any
    """Knowledge of each branch, N_KNOWN numbers, written."""


class Sure(NamedTuple):
    """Knowledge of a branch before its last angles are (``chain.accuracy``)."""

    missed: Any
    """The square of the residual so far."""
    near: Any
    """The product of a^2 apart over the angles so far."""
    sure: Any
    """a^4 of the angle that is determined least."""
    apart: Any
    """Share of a^2 that the discriminant is, where it is the least."""
