"""Forward kinematics and Jacobians bound to a link: the same bits and the same refusals as the methods, for less of a call."""

import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest

import formulas
import robots
import ulna
from assertions import assert_close
from ulna.errors import InputError, UnknownNameError
from ulna.kernels.layout import LARGEST
from ulna.robot import Robot

ROBOT = Robot(robots.every_joint())
BOUND = {
    "forward": (lambda robot: robot.compile_forward(link="hand"), lambda robot, q: robot.forward_kinematics(q, link="hand")),
    "base": (lambda robot: robot.compile_jacobian(link="hand"), lambda robot, q: robot.jacobian(q, link="hand")),
    "link": (
        lambda robot: robot.compile_jacobian(link="hand", expressed_in="link"),
        lambda robot, q: robot.jacobian(q, link="hand", expressed_in="link"),
    ),
}


@pytest.fixture(params=BOUND)
def pair(request):
    compiled, method = BOUND[request.param]
    return compiled(ROBOT), lambda q: method(ROBOT, q)


def sent_and_back(thing):
    return pickle.loads(pickle.dumps(thing))  # noqa: S301 - our own


def positions(rng, *shape):
    return rng.uniform(-1.4, 1.4, (*shape, ROBOT.n_dof))


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 9), (0,)])
def test_it_gives_the_bits_of_the_method(pair, rng, shape):
    compiled, method = pair
    q = positions(rng, *shape)
    assert compiled(q).tobytes() == method(q).tobytes()
    out = np.full_like(compiled(q), np.nan)
    assert compiled(q, out) is out
    assert out.tobytes() == method(q).tobytes()


def test_the_pose_is_that_of_the_plain_python_formula(rng):
    q = positions(rng)
    assert_close(ROBOT.compile_forward(link="hand")(q), formulas.link_pose(ROBOT.description, q, "hand"), atol=2e-14)
    assert_close(ROBOT.compile_jacobian(link="hand")(q), formulas.jacobian(ROBOT.description, q, "hand", "base"), atol=1e-10)


@pytest.mark.parametrize("form", [list, tuple, np.float32, lambda q: q[::-1].copy()[::-1], lambda q: np.repeat(q, 2)[::2]])
def test_numbers_of_any_kind_are_taken(pair, rng, form):
    compiled, method = pair
    q = np.round(positions(rng) * 64) / 64
    assert compiled(form(q)).tobytes() == method(q).tobytes()


def test_a_read_only_q_is_taken(pair):
    compiled, method = pair
    assert not ROBOT.home.flags.writeable
    assert compiled(ROBOT.home).tobytes() == method(ROBOT.home).tobytes()


def test_a_read_only_q_takes_the_fast_route_as_another_does(pair, rng, monkeypatch):
    compiled, _ = pair
    monkeypatch.setattr(type(compiled), "_validated", lambda *_: pytest.fail("the route of what must be converted"))
    fast = sent_and_back(compiled)  # in C the slow route is bound when it is made
    q = positions(rng)
    expected = fast(q).tobytes()
    q.flags.writeable = False
    assert fast(q).tobytes() == expected
    assert fast(q, out := np.empty_like(fast(q))) is out
    assert out.tobytes() == expected


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1.01 * LARGEST])
def test_numbers_out_of_range_are_refused_by_place(pair, rng, bad):
    compiled, _ = pair
    q, out = positions(rng), np.zeros_like(compiled(ROBOT.home))
    q[2] = bad
    for ask in (lambda: compiled(q), lambda: compiled(q, out), lambda: compiled(list(q))):
        with pytest.raises(InputError, match=r"q\[2\]"):
            ask()
    assert not out.any(), "what is refused leaves no answer behind"


@pytest.mark.parametrize("shape", [(), (1,), (12,), (3, 4)])
def test_another_number_of_joints_is_refused(pair, shape):
    compiled, _ = pair
    with pytest.raises(InputError, match="shape"):
        compiled(np.zeros(shape))


@pytest.mark.parametrize(
    "q",
    [
        np.ma.zeros(13),
        np.zeros(13, complex),
        np.array(["0"] * 13),
        np.zeros(13, "M8[s]"),
        np.zeros(13, "f8,f8"),
        np.array([None] * 13),
        None,
    ],
)
def test_what_is_no_array_of_numbers_is_refused(pair, q):
    with pytest.raises(InputError):
        pair[0](q)


def test_q_itself_cannot_be_out(pair, rng):
    compiled, _ = pair
    block = np.zeros(2 * compiled(ROBOT.home).size)
    q, out = block[: ROBOT.n_dof], block[: block.size // 2].reshape(compiled(ROBOT.home).shape)
    q[:] = positions(rng)
    before = block.copy()
    with pytest.raises(InputError, match="shares memory"):
        compiled(q, out)
    assert np.array_equal(block, before)
    beside = block[block.size // 2 :].reshape(out.shape)
    assert np.array_equal(compiled(q, beside), compiled(q.copy()))


def test_a_robot_without_joints_has_them_too():
    fixed = Robot(robots.two_links("fixed", robots.Z))
    assert np.array_equal(fixed.compile_forward()([]), fixed.forward_kinematics(np.zeros(0)))
    assert fixed.compile_jacobian()(np.zeros(0)).shape == (6, 0)
    assert fixed.compile_jacobian()(np.zeros((3, 0))).shape == (3, 6, 0)
    for q in (np.zeros(1), [0.0]):
        with pytest.raises(InputError, match="no moving joints"):
            fixed.compile_forward()(q)


def test_unknown_links_and_frames_are_refused_at_once():
    for link in ("hnad", 3, ["hand"]):
        for make in (ROBOT.compile_forward, ROBOT.compile_jacobian):
            with pytest.raises(UnknownNameError):
                make(link=link)
    for frame in ("bse", None, ["base"]):
        with pytest.raises(InputError, match="expressed_in"):
            ROBOT.compile_jacobian(link="hand", expressed_in=frame)
    with pytest.raises(InputError, match="several tips"):
        ROBOT.compile_forward()


def test_it_survives_pickling_with_nothing_writable(pair, rng):
    compiled, method = pair
    again, q = sent_and_back(compiled), positions(rng)
    assert again(q).tobytes() == method(q).tobytes()
    assert again(q[None]).tobytes() == method(q[None]).tobytes()
    assert repr(again) == repr(compiled)
    tree = sent_and_back(ROBOT.tree)
    arrays = [tree.joints, tree.link_frames, tree.lower, tree.limits, tree.chain("hand"), tree.link_offset["hand"]]
    assert not any(array.flags.writeable for array in arrays)


@pytest.mark.process
def test_another_process_can_be_sent_one():
    code = "import pickle, sys; fk, q = pickle.load(sys.stdin.buffer); print(fk(q)[:3, 3].round(12).tolist())"
    panda = ulna.load("panda")
    sent = pickle.dumps((panda.compile_forward(), panda.home))
    done = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True, check=True)
    assert done.stdout.decode().strip() == str(panda.forward_kinematics(panda.home)[:3, 3].round(12).tolist())


def test_many_threads_at_once_each_get_their_own_result(pair, rng):
    compiled, method = pair
    batches = positions(rng, 4, 300)
    answers = [None] * len(batches)

    def ask(k):
        out = np.empty_like(compiled(ROBOT.home))
        answers[k] = np.array([compiled(q, out).copy() for q in batches[k]])

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(len(batches))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for batch, answer in zip(batches, answers, strict=True):
        assert answer.tobytes() == np.array([method(q) for q in batch]).tobytes()
