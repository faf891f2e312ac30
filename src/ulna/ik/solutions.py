"""Holds all solutions of targets, and their proofs."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import TruthError
from ulna.ik.reason import NO_REASON, Reason
from ulna.notebook.tables import OneLine

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_set = object.__setattr__


class Proof(StrEnum):
    """The certainty about the solutions of a target."""

    COMPLETE = "complete"
    COINCIDING = "complete but for coinciding branches"
    CONTINUUM = "continuum"
    SEARCHED = "searched"


PROOFS = tuple(Proof)
_WORDS = np.array(PROOFS)


@dataclass(frozen=True, eq=False, repr=False)
class IKSolutions(OneLine):
    """The solutions of targets of shape (..., 4, 4); m is the same for all of them.

    For one target, ``bool(found)`` is True if any solution is valid.

    ========================================= ==========================================================================
    ``complete``                              The closed form gives every solution; a target without one is out of reach.
    ``complete but for coinciding branches``  The same, but two branches nearly coincide: their angle is less accurate.
    ``continuum``                             A joint may have any angle up to rounding, or the arm has a redundant joint: the
                                              solutions are examples.
    ``searched``                              They come from a search, to its tolerances and within the limits, or from the
                                              closed form if rounding leaves its completeness open: some may be missing.
    ========================================= ==========================================================================

    Attributes:
        q: Joint positions [rad or m], shape (..., m, n_dof); NaN where there is no solution.
        valid: Whether they are solutions within the joint limits and, if a world was given, free of collision, shape (..., m).
        real: Whether they are solutions, shape (..., m).
        proof: The proof, shape (...): for one target a ``Proof``.
        family: The family of the closed form, with the held joint and the end from which the axes are counted; empty for an arm
            without a closed form.
        colliding: The number of solutions within the joint limits that collide, shape (...); 0 without a world.
    """

    q: Array
    valid: Truths
    real: Truths
    proof: Proof | NDArray[Any]
    family: str
    colliding: int | NDArray[np.int64] = 0

    def __post_init__(self) -> None:
        for each in (self.q, self.valid, self.real, self.proof, self.colliding):
            if isinstance(each, np.ndarray):
                each.flags.writeable = False

    @classmethod
    def of_one(cls, q: Array, valid: Truths, real: Truths, proof: Proof, family: str) -> "IKSolutions":
        """The solutions of one target, made in less time, from read-only arrays."""
        found = object.__new__(cls)
        _set(found, "__dict__", {"q": q, "valid": valid, "real": real, "proof": proof, "family": family})
        return found

    @classmethod
    def of_many(
        cls, q: Array, valid: Truths, real: Truths, proved: NDArray[np.int64], family: str, colliding: NDArray[np.int64]
    ) -> "IKSolutions":
        """The solutions of a batch. ``proved`` are indices into ``Proof``; ``proof`` is made from them at its first use."""
        for each in (q, valid, real, colliding):
            each.setflags(write=False)
        found = object.__new__(cls)
        _set(
            found, "__dict__", {"q": q, "valid": valid, "real": real, "_proved": proved, "family": family, "colliding": colliding}
        )
        return found

    def __bool__(self) -> bool:
        if self.valid.ndim > 1:
            raise TruthError("an IKSolutions", "found.success")
        return bool(self.success)

    @property
    def success(self) -> bool | Truths:
        """Whether there is a valid solution, shape (...)."""
        return np.asarray(self.valid.any(axis=-1)) if self.valid.ndim > 1 else bool(self.valid.any())

    @property
    def reason(self) -> Reason:
        """For one target: the reason why no solution is valid, with the numbers of real and colliding ones."""
        if self.valid.ndim > 1 or self.success:
            return NO_REASON
        real = int(self.real.sum())
        data = {"real": real, "colliding": self.colliding}
        if self.colliding:
            count = f"all {self.colliding} solutions" if self.colliding > 1 else "the only solution"
            return Reason(f"{count} within the joint limits touch{'es' * (self.colliding == 1)} something", data)
        if real:
            count = f"all {real} solutions are" if real > 1 else "the only solution is"
            return Reason(f"{count} beyond the joint limits", data)
        proved = self.proof in {Proof.COMPLETE, Proof.COINCIDING}
        return Reason("the closed form proves that there is no solution" if proved else "no solution was found", data)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """The proof of a batch: to write its words takes a tenth of the time of the solutions."""
        if name != "proof" or "_proved" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        proof = _WORDS[self.__dict__["_proved"]]
        proof.setflags(write=False)
        return self.__dict__.setdefault("proof", proof)

    def __getstate__(self) -> dict[str, Any]:
        """The fields, computed ones included."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore the fields as read-only arrays: copied or unpickled arrays are writable."""
        self.__dict__.update(state)
        self.__post_init__()

    def __str__(self) -> str:
        counts, proofs = np.atleast_1d(self.valid.sum(axis=-1)).ravel(), np.atleast_1d(self.proof)
        words = [f"{count} {word}" for word in Proof if (count := np.count_nonzero(proofs == word))]
        proved = str(self.proof) if isinstance(self.proof, Proof) else ", ".join(words)
        if not counts.size:
            return "no targets"
        found = " to ".join(str(count) for count in sorted({counts.min(), counts.max()}))
        return f"{found} solution{'s' * (found != '1')} within the limits ({proved})" + (
            f"; {self.family}" if self.family else ""
        )
