"""What a page holds, where a signal interrupts a change of it: its session, its plan, its steering, and what can be undone."""

import copy

import numpy as np
import pytest

import ulna
from interrupts import interrupted_at_every_place
from ulna.collision.world import exchange
from ulna.viewer.session.clearance import clearance
from ulna.viewer.session.hand import FollowResult
from ulna.viewer.session.planned_motion import PlannedMotion, Planning
from ulna.viewer.session.scene_history import SceneHistory, scene_of
from ulna.viewer.session.session import Session
from ulna.viewer.session.steering import Steering

SMALL, LARGE = ulna.Sphere(0.02), ulna.Box((0.2, 0.1, 0.3))
GOAL = ulna.pose((0.5, 0.1, 0.5), (3.0, 0.1, 0.0))


def world_of_two():
    world = ulna.World()
    world.add("ball", SMALL, ulna.pose((0.9, -0.2, 0.3)))
    world.add("trolley", LARGE, ulna.pose((0.9, 0.3, 0.5)), touch_links=["panda_link8"], speed=0.1)
    return world


# ---- what can be undone --------------------------------------------------------------------------------------------------


def history_of_three():
    """A history whose first two steps are done, and a third is undone."""
    world = world_of_two()
    history = SceneHistory(world)
    with history.step():
        world.move("ball", GOAL)
    with history.step():
        world.reshape("trolley", SMALL)
        world.remove("ball")
        world.add("new", LARGE, GOAL, touch_links=["panda_link7"])
    with history.step():
        world.remove("new")
    history.undo()
    return world, history


def step(world, history):
    with history.step():
        world.add("other", LARGE, GOAL)


def program_step(_, history):
    history.add_acts(lambda: (), lambda: ())


def scene(world):
    return {name: (str(of.shape), of.T.tobytes(), of.touch_links, of.speed) for name, of in scene_of(world).items()}


def story(world, history):
    """The scenes that undoing and doing again lead through, all steps back and all on."""
    story, can = [history.can_undo, history.can_redo], (history.can_undo, history.can_redo)
    story.append(scene(world))
    for act in (history.undo, history.redo):
        while can[0] if act == history.undo else can[1]:
            act()
            story.append(scene(world))
            can = history.can_undo, history.can_redo
    return story


ACTS = {
    "step": step,
    "add_acts": program_step,
    "undo": lambda _, history: history.undo(),
    "redo": lambda _, history: history.redo(),
}


@pytest.mark.parametrize("name", ACTS)
def test_a_step_that_is_interrupted_is_done_or_undone_in_whole_or_not_at_all(name):
    pair, act = history_of_three(), ACTS[name]
    before = story(*pair)
    pair = history_of_three()
    act(*pair)
    after, found = story(*pair), set()

    def judge(pair):
        told = story(*pair)
        assert told in (before, after)
        found.add(told == after)

    assert interrupted_at_every_place(history_of_three, lambda pair: act(*pair), judge) > 5
    assert True in found


def test_several_objects_are_exchanged_all_or_none():
    other = ulna.World()
    other.add("new", LARGE, GOAL)
    other.add("trolley", SMALL, GOAL)
    after = world_of_two()
    exchange(after, ["ball", "unknown"], other)
    assert after.names == ("trolley", "new")
    assert (after.speed("trolley"), after.touch_links("trolley"), after.shape("trolley")) == (None, frozenset(), SMALL)
    scenes = [scene(world_of_two()), scene(after)]

    def judge(world):
        assert scene(world) in scenes
        assert {one.name for one in world.objects().moving} == {name for name in world.names if world.speed(name) is not None}

    assert interrupted_at_every_place(world_of_two, lambda world: exchange(world, ["ball"], other), judge, each=True) > 5


# ---- the session, the plan and the steering ------------------------------------------------------------------------------


def quick(_, question, *arguments, **options):
    """Calls the functions of a frame; only that the hand follows is shown in less time: by a small step, three times."""
    if question.__name__ not in {"follow", "place"}:
        return question(*arguments, **options)
    q = arguments[0] + 0.01
    return FollowResult(q, reached=False, moving=q[0] < 0.035, reason="it is far" if q[0] > 0.035 else "", stopped=q[0] > 0.035)


@pytest.fixture(scope="module")
def session_of(panda):
    """Makes sessions whose hand is pulled, and that had a frame."""
    first = Session(panda, world_of_two(), panda.home, quick)
    first.pull(GOAL)
    first.frame()

    def make():
        session = copy.copy(first)
        session.world = first.world.copy()
        return session

    return make


SESSION = {
    "q": lambda session: setattr(session, "q", session.robot.home),
    "link": lambda session: setattr(session, "link", "panda_link5"),
    "pull": lambda session: session.pull(GOAL),
    "send": lambda session: session.send(ulna.pose((0.4, 0.2, 0.6), (3.0, 0, 0))),
    "let_go": lambda session: session.release(),
    "use": lambda session: session.use(session.robot.with_allowed_collisions([("panda_link5", "panda_link7")])),
}


def told(session):
    target = None if session.target is None else session.target.tobytes()
    words = session.trouble, session.send_failure, session.stopped, session.waiting, session.moving
    return session.q.tobytes(), session.link, target, *words, session.robot.allowed_collisions


def outlook(session):
    """What the next frames bring."""
    frames = []
    for _ in range(4):
        session._follow()
        frames.append(told(session))
    return frames


@pytest.mark.slow
@pytest.mark.parametrize("name", SESSION)
def test_a_change_of_a_session_that_is_interrupted_is_made_in_whole_or_not_at_all(session_of, name):
    expected = []
    for act in (lambda _: None, SESSION[name]):
        session = session_of()
        act(session)
        expected.append((told(session), outlook(session)))

    def judge(session):
        assert (told(session), outlook(session)) in expected

    assert interrupted_at_every_place(session_of, SESSION[name], judge) >= 1


@pytest.mark.parametrize(
    "change",
    [
        SESSION["q"],
        pytest.param(SESSION["use"], marks=pytest.mark.slow),
        lambda session: session.world.move("ball", session.hand_pose),
    ],
)
def test_after_a_frame_that_is_interrupted_the_clearance_is_that_of_what_is_shown(session_of, change):
    def make():
        session = session_of()
        session.target = None
        change(session)
        return session

    def judge(session):
        session.frame()
        fresh = clearance(session.robot, session.q, session.world, itself=session.itself, names=session.names)
        assert (str(session.clearance), session.clearance.distance) == (str(fresh), fresh.distance)

    assert interrupted_at_every_place(make, lambda session: session.frame(), judge) > 20


def planning_of(session, robot):
    """A plan of a line, without a search, of which a part is played."""
    planning = Planning(session)
    motion = robot.trajectory([robot.home, robot.home + 0.3], velocity=1.0, acceleration=2.0)
    shown = PlannedMotion(None, motion, np.empty((0, 3)), motion.q[-1])
    session.ask = lambda *_: shown
    planning.turn(on=True)
    planning.send_configuration(robot.home + 0.3)
    planning.frame(0.0)
    planning.play()
    planning.frame(0.1)
    return planning


def told_of(planning):
    return planning.on, planning.playing, planning.waiting, planning.shown is None, planning._goal is None, planning.share > 0.0


PLANNING = {
    "turn": lambda planning: planning.turn(on=False),
    "turn on": lambda planning: planning.turn(on=True),
    "play": lambda planning: planning.play(),
    "scrub": lambda planning: planning.scrub(0.5),
    "start_here": lambda planning: planning.start_here(),
    "send": lambda planning: planning.send(GOAL),
}


@pytest.mark.parametrize("name", PLANNING)
def test_a_change_of_a_plan_that_is_interrupted_is_made_in_whole_or_not_at_all(panda, name):
    def make():
        return planning_of(Session(panda, None, panda.home), panda)

    before, after = make(), make()
    PLANNING[name](after)
    assert interrupted_at_every_place(make, PLANNING[name], lambda planning: _among(planning, before, after)) >= 1


def _among(planning, *others):
    assert told_of(planning) in [told_of(other) for other in others]


def test_a_plan_that_is_interrupted_while_it_plays_goes_on(panda):
    def judge(planning):
        assert planning.playing
        planning.frame(0.1)
        assert planning.playing
        motion = planning.shown.motion
        np.testing.assert_allclose(planning._session.q, motion.at(planning.share * motion.duration).q)

    def make():
        return planning_of(Session(panda, None, panda.home), panda)

    assert interrupted_at_every_place(make, lambda planning: planning.frame(0.1), judge) > 10


def test_steering_that_is_interrupted_goes_on_from_the_last_command(panda):
    """It does not begin anew from rest, as it does where the arm was moved by other means."""
    session = Session(panda, ulna.World(), panda.home)
    first = Steering(session)
    first.turn(on=True)
    first._release_times[1, 0] = np.inf
    for _ in range(10):
        first.frame(0.01)
    servo, q = first._servo, session.q

    def make():
        steering = copy.copy(first)
        steering._session = Session(panda, session.world, q)
        steering._servo, steering._servo_state = copy.copy(servo), None
        steering._servo_state = steering._state()
        return steering

    def judge(steering):
        speed = np.abs(steering._servo.qd).max()
        steering.frame(0.005)
        assert np.abs(steering._servo.qd).max() > 0.5 * speed > 0.0
        assert np.array_equal(steering._session.q, steering._servo.q)

    assert interrupted_at_every_place(make, lambda steering: steering.frame(0.005), judge) > 20
    ended = make()
    ended.turn(on=False)
    assert interrupted_at_every_place(make, lambda steering: steering.turn(on=False), lambda s: _ended(s, servo)) >= 1


def _ended(steering, servo):
    assert (steering.on, steering._servo is None, steering.command is None) in {(True, False, False), (False, True, True)}
