"""No frame of a page waits for the compiler: kernels compile in another thread, the page says so, and the call is repeated."""

import subprocess
import sys
import threading

import pytest

import ulna
from processes import wait_for
from ulna.engine.decorators import NotCompiledError, compiling_if
from ulna.viewer.compiler import Compiler, rehearsals

# A separate program, in which no kernel is loaded. It cannot compile while another thread holds Numba's lock.
HELD = """
import numpy as np, ulna
from numba.core.compiler_lock import global_compiler_lock
from processes import wait_for

panda = ulna.load("panda")
with ulna.view(panda) as view:
    with global_compiler_lock:
        view.world.add("ball", ulna.Sphere(0.05), ulna.pose((0.65, 0.0, 0.5)))
        wait_for(lambda: "Compiling for this machine (once): " in view.notice.text, "the word of it")
        assert "checking ..." in view.clearance.state.content
        wait_for(lambda: "ball" in view.obstacles.nodes, "the ball")
        view.q = panda.home + 0.1
        there = panda.forward_kinematics(view.q, link=panda.link_names[-1])[:3, 3]
        wait_for(lambda: np.allclose(view.arm.frames[-1].position, there), "the arm where it is now")
        start = view.session.hand_pose
        view.session.pull(start @ ulna.pose((0, 0, -0.05)))
        wait_for(lambda: "waiting for the motion" in view.hand.status.content, "the hand that waits")
        view.session.release()
        assert not view.ready
    wait_for(lambda: view.session.target is None, "the hand that has followed", looks=None)
    assert np.allclose(view.session.hand_pose, start @ ulna.pose((0, 0, -0.05)), atol=2e-5)
    wait_for(lambda: view.session.clearance.nearest is not None, "the nearest pair", looks=None)
    wait_for(lambda: view.notice.text == "", "no more to say", looks=None)
print("done")
"""


@pytest.mark.process
@pytest.mark.compiler
def test_while_a_kernel_compiles_the_page_keeps_drawing_and_says_so(tmp_path):
    path = ":".join(sys.path)
    done = subprocess.run([sys.executable, "-c", HELD], env={"PYTHONPATH": path}, capture_output=True, text=True, check=False)
    assert done.stdout == "done\n", done.stderr


@pytest.mark.compiler
def test_a_call_that_would_compile_is_refused_and_works_once_compiled(panda):
    source = """
import numpy as np, ulna
from ulna.engine.decorators import NotCompiledError, compiling_if
panda = ulna.load("panda")
for question in (panda.forward_kinematics, panda.link_poses):
    try:
        with compiling_if(lambda: False):
            question(panda.home)
    except NotCompiledError as error:
        print(error)
    expected = question(panda.home)
    with compiling_if(lambda: False):
        assert np.array_equal(question(panda.home), expected)
"""
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["forward_one", "frames_one"]


def test_the_rehearsals_compile_all_that_the_page_calls(panda):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.05), ulna.pose((0.65, 0.0, 0.5)))
    for _, rehearse in rehearsals(panda, checked=True):
        rehearse()
        with compiling_if(lambda: False):
            rehearse()


class Question:
    """A call that must be compiled first; the test sets ``compiled`` when that is to end."""

    def __init__(self):
        self.compiled, self.asked = threading.Event(), threading.Event()
        self.done = False

    def __call__(self):
        if not self.done:
            from ulna.engine import decorators as permission

            if not permission._permission.may():
                raise NotCompiledError("a kernel")
            self.asked.set()
            assert self.compiled.wait(60)
            self.done = True
        return 42


@pytest.fixture
def woken():
    return threading.Event()


@pytest.fixture
def compiler(woken):
    compiler = Compiler(woken.set)
    yield compiler
    compiler.stop(60)


def test_a_call_returns_none_until_it_is_compiled_in_the_other_thread(compiler, woken):
    question = Question()
    assert compiler.ask("it", question) is None
    assert question.asked.wait(60)
    assert compiler.ask("it", question) is None
    assert compiler.names == ("it",)
    question.compiled.set()
    assert woken.wait(60)
    assert compiler.ask("it", question) == 42
    assert compiler.pop_finished()
    assert not compiler.pop_finished()
    assert compiler.names == ()


def test_a_call_that_a_person_waits_for_is_compiled_before_prepared_ones(compiler, woken):
    first, later, asked = Question(), Question(), Question()
    compiler.prepare("first", first)
    assert first.asked.wait(60)
    compiler.prepare("later", later)
    assert compiler.ask("asked", asked) is None
    assert compiler.names == ("first", "asked", "later")
    for question in (first, asked, later):
        question.compiled.set()
    wait_for(lambda: compiler.names == (), "the end of all")
    assert later.done


def test_a_failed_compilation_is_logged_and_raised_at_the_next_call(compiler, woken, capsys):
    def question():
        from ulna.engine import decorators as permission

        if not permission._permission.may():
            raise NotCompiledError("a kernel")
        raise ArithmeticError("of the compiler")

    assert compiler.ask("it", question) is None
    assert woken.wait(60)
    wait_for(lambda: not compiler.names, "its end")
    with pytest.raises(ArithmeticError):
        compiler.ask("it", question)
    assert "ArithmeticError: of the compiler" in capsys.readouterr().err


def test_stopping_waits_for_the_running_compilation_and_starts_no_other(compiler):
    first, later = Question(), Question()
    compiler.prepare("first", first)
    assert first.asked.wait(60)
    compiler.prepare("later", later)
    compiler.stop(0.0)
    assert not compiler.ended
    first.compiled.set()
    compiler.stop(60)
    assert compiler.ended
    assert first.done
    assert not later.done
    compiler.prepare("never", later)
    assert compiler.ended
