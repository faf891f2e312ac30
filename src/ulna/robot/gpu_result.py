"""Holds the results of a search whose solutions stay on a GPU. Used by ``robot.gpu_robot``."""

from functools import cached_property
from typing import Any

from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.result import Array, IKResult


class DeviceResult(IKResult):
    """An ``IKResult`` whose q is on the device; all else is copied to the host when it is first asked for."""

    def __init__(
        self,
        q: Any,
        info: Any,
        batch: tuple[int, ...],
        tolerances: tuple[float, float],
        explanation: Explanation = NOTHING_TO_EXPLAIN,
    ) -> None:
        known = {"q": q, "_there": info, "_batch": batch, "tolerances": tolerances, "explanation": explanation}
        for name, value in known.items():
            object.__setattr__(self, name, value)

    @cached_property
    def info(self) -> Array:  # pyright: ignore[reportIncompatibleVariableOverride] - it is as read-only
        """What is known of each target, a row each."""
        return self.__dict__["_there"].copy_to_host()

    def __reduce__(self) -> Any:
        q: Any = self.q
        return IKResult, (q.copy_to_host(), self.info, self._batch, self.tolerances, self.explanation)
