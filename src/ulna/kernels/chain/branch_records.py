"""Names the parts of a closed form's branches that its kernels pass on."""

from typing import Any, NamedTuple


class Branches(NamedTuple):
    """The rows of all branches, which the caller owns (``closed_form.closed_form``)."""

    sign_rows: Any
    """3 n rows."""
    n: int
    """Number of signs of each of three choices."""
    free_rows: Any
    """Twelve rows: sines and cosines of the values for undetermined angles."""
    q_rows: Any
    """Six rows a branch, output."""
    known_rows: Any
    """N_KNOWN rows a branch: its residual and accuracy, output."""


class Accuracy(NamedTuple):
    """The residual and accuracy of a branch before its last angles are computed (``chain.accuracy``)."""

    residual_square: Any
    """The square of the residual up to here."""
    conditioning: Any
    """The product of a^2 times the separation over the angles up to here."""
    determination: Any
    """The minimum of a^4 over the angles, with a the amplitude of an angle's equation."""
    separation: Any
    """The minimum over the angles of the discriminant as a share of a^2."""
