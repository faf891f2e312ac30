"""Shows a robot on a page, where a person moves it among obstacles, while the program continues."""

import html
import time
from collections.abc import Callable
from functools import partial
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from viser import GuiTabGroupHandle

from ulna.collision.attached import Attached
from ulna.collision.world import World, exchange
from ulna.description.arrays import as_switch, positive
from ulna.description.meshes.hulls import in_place_of_meshes
from ulna.description.pose import inverse
from ulna.description.shapes import HalfSpace, Solid
from ulna.robot import Robot
from ulna.viewer.arm import Arm, VisibilityPanel
from ulna.viewer.compiler import Compiler, rehearsals
from ulna.viewer.front_tab import FrontTabs
from ulna.viewer.html import copy_button, small_text
from ulna.viewer.joint_sliders import JointSliders
from ulna.viewer.link_panel import LinkPanel, held_by
from ulna.viewer.loop import Loop
from ulna.viewer.move_panel import ConfigurationPanel, HandPanel
from ulna.viewer.obstacles import Obstacles
from ulna.viewer.page import HOST, Page
from ulna.viewer.plan_panel import PlanPanel
from ulna.viewer.readings import ClearancePanel, EllipsoidPanel, Notice
from ulna.viewer.session.changes import Changes
from ulna.viewer.session.loads import TORQUES, has_inertias, loads
from ulna.viewer.session.scene_history import Scene, scene_of, world_of
from ulna.viewer.session.session import Session
from ulna.viewer.stage import Floor, SightPanel, add_stage, floor_height, height_under, scene_extent
from ulna.viewer.steer_panel import SteerPanel
from ulna.viewer.undo_panel import UndoPanel

FRAME_S = 1 / 60
IDLE_S = 1 / 20  # between frames at rest, since the program may have changed the world
_LOADING_S = 0.5  # after this time the page shows that it compiles; loading from disk is faster
_TABS = "Move", "Obstacles", "Plan", "Steer", "Look"
_ONE_MOVE_S = 0.5  # after this time without an event, a motion of the arm becomes a step to undo
_STOP_WITHIN_S = 60.0  # maximum time to wait for a compilation


class View:
    """A running view; see ``ulna.view``.

    Attributes:
        url: The address of the page.
        world: The obstacles. The program may change them at any time, and the page shows the change.
        response_time: The time from the last event to the end of its frame [s].
    """

    def __init__(
        self,
        robot: Robot,
        world: World | None = None,
        *,
        q: ArrayLike | None = None,
        host: str = HOST,
        port: int = 0,
        origins: tuple[str, ...] = (),
        steer: bool = False,
        jerk: float | None = None,
    ) -> None:
        self.response_time, begin_steering = 0.0, as_switch("steer", steer)
        self._event_time: float | None = None
        self._rehearsed = False
        self._modes = False, False  # whether planning and steering were on in the last frame
        self._loop = Loop("ulna-view", self._timed_frame, lambda: FRAME_S if self._moving else IDLE_S, self._failed)
        self.compiler = Compiler(self._loop.wake)
        self.session = Session(robot, world, q, self.compiler.ask)
        self.page = Page(host, port, title=f"{robot.name} - Ulna", origins=origins)
        with self.page.ending_if_it_fails():
            self._build(steer=begin_steering, jerk=None if jerk is None else positive("jerk", jerk))
        self._loop.start()
        self.page.server.on_client_connect(self._rehearse)

    def _build(self, *, steer: bool, jerk: float | None) -> None:
        server, session, robot = self.page.server, self.session, self.session.robot
        self._first_robot = self._shown_robot = robot
        self._has_inertias = has_inertias(robot)
        self.changes, self._q_at_rest, self._last_event_time = Changes(), session.q, None
        self._last_selection: tuple = (), "", frozenset()
        self.arm = Arm(server, robot)
        self.arm.move_to(session.q)
        extent = self.arm.extent
        ground = add_stage(self.page, extent, scene_extent(session.world, extent))
        self._floor_height, self._floor_objects = float(ground.position[2]), ()
        self.clearance = ClearancePanel(server, extent.radius)
        self.allow = server.gui.add_button(
            "Allow these contacts", hint="These links may touch from now on; Ctrl-Z undoes it", visible=False
        )
        self.allowed = server.gui.add_html("", visible=False)
        self.allow.on_click(lambda _: self._allow())
        self.in_place_of_meshes = in_place_of_meshes(robot.description)
        if self.in_place_of_meshes:
            server.gui.add_html(small_text(self.in_place_of_meshes))
        self.notice = Notice(server.gui)
        self.undoing = UndoPanel(server.gui)
        acts = (
            (self._allow_label, self._allow_contacts_of),
            (self._attach_label, self._attach),
            (self._put_down_label, self._put_down),
            (lambda link: "Show this link" if link in self.arm.hidden else "Hide this link", self._hide),
        )
        self.link = LinkPanel(server.gui, session, self._set_limit, self._set_mass, acts, self._on_event)
        self.arm.on_click(self.link.choose)
        tabs = server.gui.add_tab_group()
        self.steer = self._add_steering(tabs, jerk, on=True) if steer else None  # the first tab is open at first
        with tabs.add_tab("Move"):
            self.hand = HandPanel(server, session, extent.radius, self._on_event) if robot.n_dof else None
            self.configuration = ConfigurationPanel(server.gui, session, self._on_event)
            self.ellipsoid = EllipsoidPanel(server, session)
            self.joints = JointSliders(server.gui, robot, self._on_event)
        with tabs.add_tab("Obstacles"):
            beside = np.round([extent.high[0] + 0.2 * extent.radius, 0.0, extent.center[2]], 2)
            self.obstacles = Obstacles(server, session.world, beside, extent.radius, self._on_event, session.names.reserved)
            height = floor_height(robot, float(ground.position[2]))
            self.floor = Floor(server.gui, session.world, height, self.obstacles.changing)
            self.itself = server.gui.add_checkbox(
                "Check self-collision",
                initial_value=session.itself,
                disabled=bool(session.unchecked),
                hint=session.unchecked or None,
            )
            self.itself.on_update(lambda _: self._set_itself())
        self.plans = None
        if robot.n_dof:
            with tabs.add_tab("Plan"):
                self.plans = PlanPanel(server, session, self.arm, self._on_event)
        self.steer = self.steer or self._add_steering(tabs, jerk, on=False)
        with tabs.add_tab("Look"):
            self.sight = SightPanel(self.page, extent, lambda: scene_extent(session.world, extent))
            self.link.add_choice(server.gui)
            self.look = VisibilityPanel(server.gui, self.arm)
        self.front = FrontTabs(server, _TABS, self._on_event)
        self.undoing.step_by(self.obstacles.history, self._step)
        self._show()

    def _add_steering(self, tabs: GuiTabGroupHandle, jerk: float | None, *, on: bool) -> SteerPanel | None:
        if not self.session.robot.n_dof:
            return None
        with tabs.add_tab("Steer"):
            return SteerPanel(self.page.server.gui, self.session, self._on_event, on=on, jerk=jerk)

    @property
    def url(self) -> str:
        """The address of the page."""
        return self.page.url

    @property
    def ready(self) -> bool:
        """Whether all kernels of the page are compiled.

        Compilation starts when the page is first opened, and the page shows its progress.
        """
        return self._rehearsed and not self.compiler.names

    @property
    def world(self) -> World:
        """The obstacles around the robot."""
        return self.session.world

    @property
    def q(self) -> NDArray[np.float64]:
        """The joint positions [rad or m], shape (n_dof,). Setting them moves the robot.

        Raises:
            InputError: They have another shape or are out of range.
        """
        return self.session.q

    @q.setter
    def q(self, q: ArrayLike) -> None:
        self.session.q = q
        self._loop.wake()

    def stop(self, within: float = _STOP_WITHIN_S) -> bool:
        """Stop the page and its threads. A second call does nothing.

        Args:
            within: The maximum time to wait for the last frame, and for a compilation, which cannot be interrupted [s].

        Returns:
            Whether both have ended. If not, a program that exits waits for them, unless it calls ``os._exit``.
        """
        if not self._loop.stopping:
            self._loop.stop(within)
            self.compiler.stop(within)
            self.page.stop()
        return self._loop.ended and self.compiler.ended

    def wait(self) -> None:
        """Wait until ``stop`` is called, or for Ctrl-C."""
        self._loop.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"<View of {self.session.robot.name!r} at {self.url}>"

    def _repr_html_(self) -> str:
        """The page in a frame of a notebook."""
        title = html.escape(f"{self.session.robot.name} in 3-D", quote=True)
        look = 'width="100%" height="600" style="border:0"'
        return f'<iframe src="{html.escape(self.url, quote=True)}" title="{title}" {look}></iframe>'

    # ---- a frame ------------------------------------------------------------------------------------------------------

    def _on_event(self) -> None:
        """Note the time of an event, and wake the loop."""
        now = time.perf_counter()
        self._last_event_time = now
        if self._event_time is None:
            self._event_time = now
        self._loop.wake()

    def _rehearse(self, _: object) -> None:
        """Compile all kernels of the page when it is first opened."""
        with self.session.lock:
            if not self._rehearsed:
                for name, job in rehearsals(self.session.robot, checked=not self.session.unchecked):
                    self.compiler.prepare(name, job)
                self._rehearsed = True
        self._on_event()

    def _timed_frame(self) -> None:
        since, self._event_time = self._event_time, None
        self._frame()
        if since is not None:
            self.response_time = time.perf_counter() - since

    def _frame(self) -> None:
        session = self.session
        with session.lock, self.page.server.atomic():
            q = session.q
            if self.joints.apply_input(q):
                session.q = q
            if self.hand is not None:
                self.hand.apply_input()
            compiled = self.compiler.pop_finished()
            chosen = self.obstacles.apply_input()
            self._end_other_mode()
            planned = self.plans is not None and self.plans.apply_input()
            steered = self.steer is not None and self.steer.apply_input()
            typed = self.link.apply_input()
            self._note_moves()
            if session.frame() or chosen or compiled or planned or steered or typed or self._selection_changed():
                self._show()
            elif self.hand is not None:
                self.hand.show()
            self.notice.show_compiling(self.compiler.names if self.compiler.busy_for > _LOADING_S else ())

    def _end_other_mode(self) -> None:
        """End planning if steering was begun, and the reverse: one mode is on at a time."""
        if self._planning and self._steering and self.plans is not None and self.steer is not None:
            if self._modes[0]:
                self.plans.planning.turn(on=False)
            else:
                self.steer.steering.turn(on=False)
        self._modes = self._planning, self._steering

    @property
    def _planning(self) -> bool:
        return self.plans is not None and self.plans.planning.on

    @property
    def _steering(self) -> bool:
        return self.steer is not None and self.steer.steering.on

    def _failed(self, error: Exception | None) -> None:
        """Show on the page why a frame has failed; None removes the message."""
        self.notice.show_failure(error)

    def _selection_changed(self) -> bool:
        """Whether the chosen link, the hidden links or the tab in front differ from those shown last."""
        fronts, before = tuple(map(self.front.shows, _TABS)), self._last_selection
        if fronts != before[0]:
            self.obstacles.is_picked = False
        self._last_selection = fronts, self.link.chosen, self.arm.hidden
        return self._last_selection != before

    def _show(self) -> None:
        session, report = self.session, self.session.clearance.report
        hits = () if report is None else [pair for pair in report.pairs if pair.signed_distance <= 0.0]
        if session.robot is not self._shown_robot:
            self.arm.attach(session.robot)
            self.joints.relimit(session.robot)
            self._show_changes(session.robot)
            self._has_inertias = has_inertias(session.robot)
        self.arm.move_to(session.q)
        self.arm.mark_touching(report.touching if report is not None else ())
        pair = session.clearance.nearest
        self.arm.show_nearest("" if pair is None or pair.signed_distance <= 0.0 else pair.name_a)  # a shape in contact is red
        self.clearance.show(session.clearance)
        self.allow.visible = bool(session.own_contacts)
        if self._floor_objects != (under := session.world.objects()) and self.page.floor is not None:
            self._floor_objects = under
            self.page.floor.position = (0.0, 0.0, min(self._floor_height, height_under(session.world, self.arm.extent)))
        handled = self.front.shows("Obstacles") or self.obstacles.is_picked
        self.obstacles.show({pair.name_b for pair in hits if pair.link_b is None}, handled=handled)
        self.undoing.show()
        self.ellipsoid.show()
        self.floor.show()
        self.joints.show(session.q)
        if not self._has_inertias:
            self.joints.show_loads(())
        elif self.front.shows("Move"):
            self.joints.show_loads(session.ask(TORQUES, loads, session.robot, session.q) or ())
        self.configuration.show(session.q)
        self.link.show()
        planning = self._planning and self.front.shows("Plan")
        if self.hand is not None:
            self.hand.show()
            covered = handled and self.obstacles.covers(session.hand_pose[:3, 3])
            self.hand.handles.show(visible=self.front.shows("Move") and not planning and not covered)
        if self.plans is not None:
            self.plans.kept.changes = self.changes
            self.plans.show(handled=planning)
        if self.steer is not None:
            self.steer.show()

    @property
    def _moving(self) -> bool:
        return self.session.moving or any(panel is not None and panel.moving for panel in (self.plans, self.steer))

    # ---- changes by a person --------------------------------------------------------------------------------------------

    def _change(self, after: Changes, removed: tuple[str, ...] = (), added: Scene | None = None) -> None:
        """Change the robot, remove obstacles (``removed``) and add others (``added``), as one step to undo."""
        before, added = self.changes, added or {}
        with self.obstacles.lock:
            was = {name: entry for name, entry in scene_of(self.world).items() if name in removed or name in added}
            self._set(after, removed, added)
            undo = partial(self._set, before, (*(added.keys() - was.keys()),), was)
            self.obstacles.history.add_acts(undo, partial(self._set, after, removed, added))
        self._on_event()

    def _set(self, changes: Changes, removed: tuple[str, ...], added: Scene) -> tuple[str, ...]:
        robot = changes.apply_to(self._first_robot)  # raises before anything is changed
        self.changes = changes
        self.session.use(robot)
        exchange(self.world, removed, world_of(added))
        return tuple(added)

    def _show_changes(self, robot: Robot) -> None:
        """Show the changes of the robot on the page."""
        self._shown_robot, words = robot, self.changes.describe()
        self.allowed.visible = bool(words)
        self.allowed.content = copy_button(words, "Copy for a program", self.changes.as_expression()) if words else ""

    def _allow(self, pairs: tuple[tuple[str, str], ...] = (), added: Scene | None = None) -> None:
        """Allow contacts of pairs of links; all pairs in contact unless given. added: obstacles that links may touch."""
        robot = self.session.robot
        if not pairs and not added:
            more, known = robot.with_allowed_collisions(at=self.session.q).allowed_collisions, robot.allowed_collisions
            pairs = tuple((pair.link_a, pair.link_b) for pair in more if pair not in known)
        self._change(self.changes._replace(allowed=(*self.changes.allowed, *pairs)), (), added)

    def _contacts_of(self, link: str) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
        """The contacts of a link: the pairs with other links, and the names of obstacles."""
        report = self.session.clearance.report
        hits = () if report is None else [pair for pair in report.pairs if pair.signed_distance <= 0.0]
        pairs = tuple(pair for pair in self.session.own_contacts if link in pair)
        return pairs, tuple(dict.fromkeys(pair.name_b for pair in hits if pair.link_b is None and pair.link_a == link))

    def _allow_label(self, link: str) -> str:
        pairs, obstacles = self._contacts_of(link)
        others = [*((set(pair) - {link}).pop() for pair in pairs), *obstacles]
        return f"Allow contact with {', '.join(others)}" if others else ""

    def _allow_contacts_of(self, link: str) -> None:
        pairs, names = self._contacts_of(link)
        scene = scene_of(self.world)
        touching = {name: scene[name]._replace(touch_links=scene[name].touch_links | {link}) for name in names if name in scene}
        if pairs or touching:
            self._allow(pairs, touching)

    def _attach_label(self, link: str) -> str:
        del link
        name = self.obstacles.chosen
        shape = None if name is None else self.world.shape(name)
        return f"Attach {name}" if isinstance(shape, Solid) and not isinstance(shape, HalfSpace) else ""

    def _attach(self, link: str) -> None:
        """Attach the chosen obstacle to a link."""
        name = self.obstacles.chosen
        if name is None:
            return
        entry = scene_of(self.world)[name]
        T = inverse(self.session.robot.forward_kinematics(self.session.q, link=link)) @ entry.T
        held = Attached(name, entry.shape, T, link, entry.touch_links)  # type: ignore[arg-type]
        self._change(self.changes._replace(attached=(*self.changes.attached, held)), (name,))

    def _set_mass(self, link: str, mass: float) -> None:
        """Set the mass of the object attached to a link [kg], spread evenly over its shape; 0 for none."""
        held = held_by(self.session.robot, link)
        if held is not None:
            self._change(self.changes.with_mass(held, mass))

    def _put_down_label(self, link: str) -> str:
        names = [held.name for held in self.changes.attached if held.link == link]
        return f"Put {', '.join(names)} down" if names else ""

    def _put_down(self, link: str) -> None:
        """Turn the objects attached to a link back into obstacles, at their present poses."""
        T = self.session.robot.forward_kinematics(self.session.q, link=link)
        down = [held for held in self.changes.attached if held.link == link]
        world = World()
        for held in down:
            world.add(held.name, held.shape, T @ held.T_link_object, touch_links=held.touch_links)
        kept = tuple(held for held in self.changes.attached if held.link != link)
        self._change(self.changes._replace(attached=kept), (), scene_of(world))

    def _hide(self, link: str) -> None:
        before = self.arm.hidden
        after = before ^ {link}
        self._show_hidden(after)
        self.obstacles.history.add_acts(partial(self._show_hidden, before), partial(self._show_hidden, after))

    def _show_hidden(self, hidden: frozenset[str]) -> tuple[str, ...]:
        self.arm.show_looks(hidden=hidden)
        return ()

    def _set_limit(self, joint: str, quantity: str, value: float) -> None:
        """Set a limit of a joint, at most as wide as the robot's own."""
        self._change(self.changes.with_limit(self._first_robot, quantity, joint, value))

    def _step(self, act: Callable[[], tuple[str, ...]]) -> None:
        with self.session.lock:
            self._note_moves(at_once=True)
        self.obstacles.step(act)

    def _note_moves(self, *, at_once: bool = False) -> None:
        """Add a person's changes of the arm, the goal and the waypoints to the undo history, once the arm rests."""
        if self.plans is not None:
            self.plans.note_goals(self.obstacles.history)
        q = self.session.q
        if self._moving or (self.hand is not None and self.hand.handles.dragged):
            return
        by_person = self._last_event_time is not None
        if self._last_event_time is not None and not at_once and time.perf_counter() - self._last_event_time < _ONE_MOVE_S:
            return
        before, self._q_at_rest, self._last_event_time = self._q_at_rest, q, None
        if by_person and not np.array_equal(q, before):
            self.obstacles.history.add_acts(partial(self._move_to, before), partial(self._move_to, q))

    def _move_to(self, q: NDArray[np.float64]) -> tuple[str, ...]:
        self.session.q = self._q_at_rest = q
        return ()

    def _set_itself(self) -> None:
        self.session.itself = self.itself.value
        self._on_event()
