"""Holds the state of one view (q, the target of the hand, the world) and updates it in each frame."""

import threading
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World, refuse_no_world
from ulna.description.pose import as_one_pose
from ulna.errors import GeometryError, InputError, UnknownNameError
from ulna.kinematics.frames import frame_pose, standing_links
from ulna.kinematics.positions import as_positions, refuse_out_of_range
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.clearance import Clearance, ShapeNames, clearance
from ulna.viewer.session.first_configuration import NAME as FIRST_CONFIGURATION
from ulna.viewer.session.first_configuration import configurations_of, first_configuration
from ulna.viewer.session.hand import Hand

Array = NDArray[np.float64]
HAND, COLLISIONS = "the motion of the hand", "collisions and distances"  # the page shows these names while it compiles


def ask_at_once(_name: str, question: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Call a function at once, even if it has to be compiled first. Replaces ``Compiler.ask`` where there is no page."""
    return question(*arguments, **options)


class Session:
    """The state that all tabs and the program share. Each method may be called from any thread.

    Every method is atomic: an interrupt (Ctrl-C) leaves all of its changes or none. Each method stores its results at the end,
    with no call in between.

    Args:
        robot: The robot.
        world: The obstacles around it; an empty world unless given.
        q: The first configuration [rad or m], shape (n_dof,). Default: the SRDF's `home`, or else the robot's. If the arm is
            stretched there, it moves to a bent one (``first_configuration``) once that is compiled, unless it has moved before.
        ask: Calls the functions of a frame, as ``Compiler.ask`` does. It returns None while another thread compiles their
            kernels. Until then the hand does not move and the clearance is unknown; the next frame calls them again.

    Attributes:
        robot: The robot. ``use`` replaces it by one with other allowed contacts, limits or attached objects.
        world: The obstacles; any thread may change them at any time.
        target: The pose to which the hand is pulled, T_base_link, shape (4, 4); None if it is not pulled.
        avoiding: Whether the pulled hand avoids collisions with the world and the robot itself.
        itself: Whether self-collision is checked too.
        trouble: Why the hand has not reached its target; empty if it has, while it moves, and after release.
        send_failure: Why the hand did not reach the last pose given to ``send``; empty if it did, and after any other motion.
        stopped: Whether ``trouble`` is that the hand stopped before a collision.
        names: The shown names of the robot's collision shapes.
        clearance: The pairs in contact, and the nearest obstacle.
        waiting: Whether the pulled hand waits for kernels to be compiled.
        lock: Held during a frame; hold it to make several changes at once.

    Raises:
        InputError: ``robot`` is not a Robot, ``world`` not a World, or q has another shape or is out of range.
    """

    def __init__(
        self,
        robot: Robot,
        world: World | None = None,
        q: ArrayLike | None = None,
        ask: Callable[..., Any] = ask_at_once,
    ) -> None:
        if not isinstance(robot, Robot):
            raise InputError("robot", f"{type(robot).__name__}; an ulna.Robot is expected: ulna.load gives one")
        refuse_no_world(world)
        self.robot = self._next_robot = robot
        self.world = World() if world is None else world
        self.lock, self.ask = threading.RLock(), ask
        self.avoiding, self.itself = False, not self.unchecked
        self.clearance = Clearance(None, refusal=self.unchecked)
        self.names = ShapeNames(robot)
        self._hand = Hand(robot, hand_link(robot), self.names) if robot.n_dof else None
        self.q = configurations_of(robot)["home"] if q is None else q
        self._last_state: tuple | None = None
        self._is_released = self.waiting = self._checked = False
        self._first_q = self._q if q is None and robot.n_dof else None
        self._bend_if_stretched()

    @cached_property
    def unchecked(self) -> str:
        """Why the robot's shapes cannot be checked for collisions; empty if they can."""
        try:
            self.robot.collision_names  # noqa: B018 - asked for its error
        except GeometryError as error:
            return str(error)
        return ""

    @property
    def q(self) -> Array:
        """Joint positions [rad or m], shape (n_dof,).

        Raises:
            InputError: The new ones have another shape or are out of range.
        """
        with self.lock:
            return self._q.copy()

    @q.setter
    def q(self, q: ArrayLike) -> None:
        positions = as_positions(q, self.robot.tree)
        if positions.ndim != 1:
            raise InputError("q", f"shape {positions.shape}; one configuration, shape ({self.robot.n_dof},), is expected")
        refuse_out_of_range(positions)
        with self.lock:
            self._rest(positions.copy(), self._hand)

    @property
    def link(self) -> str:
        """The name of the hand: the link that is pulled.

        Raises:
            UnknownNameError: The robot has no link of the new name.
        """
        return self.robot.base if self._hand is None else self._hand.link

    @link.setter
    def link(self, name: str) -> None:
        if name not in self.robot.link_names:
            raise UnknownNameError("link", name, self.robot.link_names)
        with self.lock:
            if self._hand is not None:
                self._rest(self._q, Hand(self.robot, name, self.names))

    @property
    def held(self) -> tuple[str, ...]:
        """The names of the joints that do not move while the hand is pulled: planar and floating ones."""
        return () if self._hand is None else self._hand.held

    @property
    def hand_pose(self) -> Array:
        """T_base_hand, shape (4, 4)."""
        return self.robot.forward_kinematics(self.q, link=self.link)

    @property
    def frames(self) -> dict[str, Array]:
        """T_base_frame, shape (4, 4), of each reference frame for poses: fixed links, the base first, and obstacles.

        An obstacle with the name of a fixed link is left out.
        """
        tree, world = self.robot.tree, self.world.snapshot()
        names = dict.fromkeys((tree.root, *standing_links(tree)))
        links = {name: frame_pose(tree, name) for name in names}
        return links | {name: world.pose(name) for name in world.names if name not in links}

    def pull(self, T_base_hand: ArrayLike) -> None:
        """Pull the hand to a pose T_base_hand, shape (4, 4); the following frames move it there.

        Raises:
            InputError: It is not a pose.
        """
        self._pull(T_base_hand, sent=False)

    def send(self, T_base_hand: ArrayLike) -> None:
        """Send the hand to a pose T_base_hand, shape (4, 4), on any IK branch.

        The following frames move it there, or set ``send_failure``.

        Raises:
            InputError: It is not a pose.
        """
        self._pull(T_base_hand, sent=True)

    def release(self) -> None:
        """Release the hand: it still moves to its target, and then stops."""
        with self.lock:
            self._is_released = True

    def frame(self) -> bool:
        """Advance by one frame. Returns whether anything visible has changed."""
        with self.lock:
            self._apply_robot()
            self._bend_if_stretched()
            self._follow()
            seen = (
                self.robot,
                self._q.tobytes(),
                self.world.objects(),
                self.itself,
                self.link,
                self.trouble,
                self.send_failure,
                self.target is None,
            )
            changed = seen != self._last_state
            if changed:  # the last check was of another state: check again, even if this frame is interrupted
                self._last_state, self._checked = seen, False
            return not self._checked and (self._check() or changed)

    @property
    def own_contacts(self) -> tuple[tuple[str, str], ...]:
        """The pairs of the robot's links in contact at the last check, without attached objects."""
        report, held = self.clearance.report, {one.name for one in self.robot.attached}
        pairs = () if report is None else report.pairs
        touching = ((pair.link_a, pair.link_b) for pair in pairs if pair.link_b is not None and pair.signed_distance <= 0.0)
        return tuple(links for links in dict.fromkeys(touching) if held.isdisjoint(links))

    def use(self, robot: Robot) -> None:
        """Replace the robot from the next frame on by one with the same joints and links. Needs no lock."""
        self._next_robot = robot

    def _bend_if_stretched(self) -> None:
        """Move a stretched arm to a bent configuration, once, unless it has moved."""
        if self._first_q is None:
            return
        if self._q is not self._first_q or self.target is not None:
            self._first_q = None
        elif (q := self.ask(FIRST_CONFIGURATION, first_configuration, self.robot, self.world)) is not None:
            self.q, self._first_q = q, None

    def _apply_robot(self) -> None:
        wanted = self._next_robot
        if wanted is not self.robot:
            if wanted.attached != self.robot.attached:
                self.names = ShapeNames(wanted)
            hand = None if self._hand is None else Hand(wanted, self._hand.link, self.names)
            self.robot, self._hand = wanted, hand

    @property
    def moving(self) -> bool:
        """Whether the hand moves to its target."""
        return self.target is not None and self._is_moving

    _is_moving = False

    def _check(self) -> bool:
        """Compute the clearance. Returns whether it is known."""
        found = Clearance(None, refusal=self.unchecked)
        if not self.unchecked:
            found = self.ask(COLLISIONS, clearance, self.robot, self._q.copy(), self.world, itself=self.itself, names=self.names)
        shown = Clearance(None) if found is None else found
        self.clearance, self._checked = shown, found is not None
        return self._checked

    def _follow(self) -> None:
        if self.target is None or self._hand is None:
            self.waiting = False
            return
        world = self.world if self.avoiding else None
        name = COLLISIONS if self.avoiding else HAND
        followed = self.ask(name, self._hand.follow, self._q.copy(), self.target.copy(), world)
        if self._sent and followed is not None and not followed.moving and not followed.reached:
            followed = self.ask(name, self._hand.place, self._q.copy(), self.target.copy(), world)
        if followed is None:
            self.waiting = True
        elif self._is_released and not followed.moving:
            self._rest(followed.q, self._hand, followed.reason if self._sent else "")
        else:
            self._q, self.trouble, self._is_moving = followed.q, followed.reason, followed.moving
            self.stopped, self.waiting = followed.stopped, False

    def _pull(self, T_base_hand: ArrayLike, *, sent: bool) -> None:
        with self.lock:
            self.target, self._is_released = as_one_pose(T_base_hand, "T_base_hand"), sent
            self._sent, self.send_failure = sent, ""

    def _rest(self, q: Array, hand: Hand | None, send_failure: str = "") -> None:
        """Put the arm at q with a hand that is not pulled; clear the target and the reasons."""
        self._q, self._hand, self.send_failure = q, hand, send_failure
        self.target, self.trouble, self.stopped = None, "", False
        self._is_released = self._sent = self._is_moving = self.waiting = False
