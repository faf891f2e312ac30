"""Holds all solutions of targets, and what is proved of them."""

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
_put = object.__setattr__


class Proof(StrEnum):
    """What is known of the solutions of a target."""

    COMPLETE = "complete"
    COINCIDING = "complete but for coinciding branches"
    CONTINUUM = "continuum"
    SEARCHED = "searched"


PROOFS = tuple(Proof)
_WORDS = np.array(PROOFS)


@dataclass(frozen=True, eq=False, repr=False)
class IKSolutions(OneLine):
    """The solutions of targets of shape (..., 4, 4); m is the same for all of them.

    Of one target, ``if found:`` is whether any is valid.

    ========================================= ==========================================================================
    ``complete``                              The closed form gives every solution; a target without one is out of reach.
    ``complete but for coinciding branches``  The same, and two of them are nearly one: their angle is known less well.
    ``continuum``                             A joint may have any angle as far as rounding can tell, or the arm has a joint more
                                              than it needs: they are examples.
    ``searched``                              They were found by a search, to its tolerances and within the limits, or by the
                                              closed form where rounding leaves in doubt whether it has all: some may be missing.
    ========================================= ==========================================================================

    Attributes:
        q: Joint positions [rad or m], shape (..., m, n_dof); NaN where there is no solution.
        valid: Whether they are solutions within the joint limits and, if a world was given, touch nothing, shape (..., m).
        real: Whether they are solutions, shape (..., m).
        proof: What is proved, shape (...): for one target a ``Proof``.
        family: Of the closed form, with the joint that is held and the end from which the axes are counted; empty for an arm
            without a closed form.
        colliding: How many are within the joint limits, but touch something, shape (...); 0 without a world.
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
        """Those of one target, made in less time, of arrays that are read-only."""
        found = object.__new__(cls)
        _put(found, "__dict__", {"q": q, "valid": valid, "real": real, "proof": proof, "family": family})
        return found

    @classmethod
    def of_many(
        cls, q: Array, valid: Truths, real: Truths, proved: NDArray[np.int64], family: str, colliding: NDArray[np.int64]
    ) -> "IKSolutions":
        """Those of a batch: ``proved`` are the places in ``Proof``, of which ``proof`` is made when it is first read."""
        for each in (q, valid, real, colliding):
            each.setflags(write=False)
        found = object.__new__(cls)
        _put(
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
        """For one target: why no solution is valid; else no reason. Its data: how many are real, and how many collide."""
        if self.valid.ndim > 1 or self.success:
            return NO_REASON
        real = int(self.real.sum())
        data = {"real": real, "colliding": self.colliding}
        if self.colliding:
            of = f"all {self.colliding} solutions" if self.colliding > 1 else "the only solution"
            return Reason(f"{of} within the joint limits touch{'es' * (self.colliding == 1)} something", data)
        if real:
            of = f"all {real} solutions are" if real > 1 else "the only solution is"
            return Reason(f"{of} beyond the joint limits", data)
        proved = self.proof in {Proof.COMPLETE, Proof.COINCIDING}
        return Reason("the closed form proves that there is no solution" if proved else "no solution was found", data)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """The proof of a batch: its words take as long to write as a tenth of the solutions."""
        if name != "proof" or "_proved" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        proof = _WORDS[self.__dict__["_proved"]]
        proof.setflags(write=False)
        return self.__dict__.setdefault("proof", proof)

    def __getstate__(self) -> dict[str, Any]:
        """The fields, all of them made."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Copies are read-only as well: arrays are copied, and read from a file, without that."""
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
