"""Interrupts a call at every place in Ulna's frames where CPython can take a signal. The places are counted first.

CPython takes a signal after a call, at the start of a function and when a loop repeats. There are two ways of interrupting. One
arms a signal before such a place, and CPython raises there. The other raises at the instruction after a call. CPython takes no
signal when a Python function returns to another one, but nothing promises that.
"""

import _thread
import contextlib
import dis
import gc
import signal
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import ulna

HOME = str(Path(ulna.__file__).parent)
CALLS = {"CALL", "CALL_FUNCTION_EX", "CALL_KW"}
JUMPS = {"JUMP_BACKWARD"}
Place = tuple[str, CodeType, int]


class Armed(int):
    """A signal. To read ``now`` makes it pending, by C alone: so a function that traces can end before it is taken."""

    now = property(_thread.interrupt_main)


ARMED = Armed(signal.SIGINT)


@cache
def kinds_of(code: CodeType) -> dict[int, str]:
    """By the offset of an instruction: before a call, before a jump back, or after a call that is within the same handlers."""
    found, before = {}, None
    handlers = getattr(dis, "_parse_exception_table", lambda _: [])(code)
    for instruction in dis.get_instructions(code):
        if instruction.opname in CALLS or instruction.opname in JUMPS:
            found[instruction.offset] = "armed"
        if before is not None and before.opname in CALLS:
            within = [[h.target for h in handlers if h.start <= each.offset < h.end] for each in (before, instruction)]
            if within[0] == within[1]:  # otherwise it is the end of a ``with``
                found[instruction.offset] = found.get(instruction.offset, "") + "after"
        before = instruction
    return found


class Tracer:
    """Records the places that a call passes, or interrupts it at one of them. ``nth`` counts all that it passes."""

    def __init__(self, target: int | None = None) -> None:
        self.target, self.passed = target, []

    def begin(self, frame: FrameType, _: str, __: Any) -> Any:
        """Trace the frames of Ulna."""
        if not frame.f_code.co_filename.startswith(HOME):
            return None
        frame.f_trace_opcodes = True
        self.passed.append(("armed", frame.f_code, -1))
        if self.target == len(self.passed) - 1:
            sys.settrace(None)
            ARMED.now  # noqa: B018 - read, it is pending
            return None
        return self.within

    def within(self, frame: FrameType, event: str, _: Any) -> Any:
        """Note each place, and interrupt at the target."""
        if event == "opcode" and (kinds := kinds_of(frame.f_code).get(frame.f_lasti)):
            if kinds.endswith("after"):
                self.passed.append(("after", frame.f_code, frame.f_lasti))
                if self.target == len(self.passed) - 1:
                    sys.settrace(None)
                    raise KeyboardInterrupt
            if kinds.startswith("armed"):
                self.passed.append(("armed", frame.f_code, frame.f_lasti))
                if self.target == len(self.passed) - 1:
                    sys.settrace(None)
                    ARMED.now  # noqa: B018 - read, it is pending
                    return None
        return self.within


@contextlib.contextmanager
def python_raises_at_the_signal() -> Iterator[None]:
    """A context in which the signal that is armed raises KeyboardInterrupt."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def run(act: Callable[[], object], target: int | None = None) -> tuple[list[Place], bool]:
    """Call a function, interrupted at a target unless it is None: the places that it passed, and whether it was interrupted."""
    tracer, interrupted = Tracer(target), False
    tracing = sys.gettrace()
    gc.disable()  # an interrupt within a callback of the collector, as Hypothesis has one, is printed and lost
    try:
        sys.settrace(tracer.begin)
        act()
        sys.settrace(None)
        for _ in range(2):  # a signal that is still pending is taken here
            pass
    except KeyboardInterrupt:
        interrupted = True
    finally:
        sys.settrace(tracing)
        gc.enable()
    return tracer.passed, interrupted


def interrupted_at_every_place(
    make: Callable[[], Any], act: Callable[[Any], object], judge: Callable[[Any], object], *, each=False
):
    """Interrupt ``act(thing)`` at every place, of another thing that ``make`` returns each time, and judge what is left.

    each: at every time that a place is passed; otherwise at the first.

    Returns:
        How often it was interrupted.
    """
    thing = make()
    act(thing)  # what it needs is loaded
    thing = make()
    places, _ = run(lambda: act(thing))
    first = {place: nth for nth, place in reversed([*enumerate(places)])}
    targets = range(len(places)) if each else sorted(first.values())
    count = 0
    with python_raises_at_the_signal():
        for target in targets:
            thing = make()
            passed, interrupted = run(lambda thing=thing: act(thing), target)
            count += interrupted
            kind, code, offset = passed[-1]
            try:
                judge(thing)
            except BaseException as error:
                error.add_note(f"interrupted at place {target} of {len(places)}: {kind} {code.co_qualname} at {offset}")
                raise
    return count
