"""Moves a Franka Research 3 by pylibfranka, its maker's client."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from threading import Event
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.arms.arm import FR3, ArmModel, Record
from ulna.arms.commands import PERIOD, START_TOLERANCE, approach, as_tolerance, commands_of, refuse_another_robot
from ulna.arms.steering import Goal, Steering
from ulna.description.arrays import as_switch
from ulna.description.pose import inverse
from ulna.errors import ArmConnectionError, ArmError, InputError, needs_extra
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot
from ulna.servo.servo import Servo

Array = NDArray[np.float64]
_HOLD = 0.1  # [s], for which the end of a motion is commanded: the arm lags a little behind
_Sent = list[tuple[int, list[float], list[float]]]  # the tick, the command, and the position measured before it


class Franka:
    """A Franka Research 3 at an address, which follows motions; an ``Arm``.

    Only ``run`` and ``follow`` move it; connecting does not. While one of them runs, the process should do nothing else: the
    controller expects a command each millisecond, and stops the arm when several are missing.

    Attributes:
        model: ``FR3``, the limits against which a motion is checked.
        joint_names: The joints of the robot, or of each motion if no robot was given.
    """

    def __init__(
        self,
        address: str = "127.0.0.1",
        *,
        robot: Robot | None = None,
        start_tolerance: float = START_TOLERANCE,
        realtime: bool = False,
    ) -> None:
        """Connect to the arm's controller.

        Args:
            address: The controller's IP address or name; by default a simulator on this machine.
            robot: The robot for which motions are planned. It is refused unless it matches the arm: seven joints, position limits
                within the arm's, and the last joint's axis at its measured place.
            start_tolerance: Maximum distance of a joint from a motion's start [rad], at most 0.03.
            realtime: Whether a kernel with real-time priorities is required, as the maker advises for a real arm.

        Raises:
            MissingExtraError: pylibfranka is not installed.
            ArmConnectionError: There is no controller, or it refuses the connection.
            InputError: The robot is not the arm, or the tolerance is out of range.
        """
        enforced = as_switch("realtime", realtime)
        with needs_extra("a Franka", "franka", "pylibfranka"):
            import pylibfranka  # noqa: PLC0415  # pyright: ignore[reportMissingImports] - it is optional
        self.model: ArmModel = FR3
        self.joint_names: tuple[str, ...] | None = None
        self._robot: Any = ()
        self._client, self._tolerance, self._stop = pylibfranka, as_tolerance(start_tolerance), Event()
        self._measured: Array | None = None  # while a motion runs
        self._closing = False
        self._control: Any = None  # while a motion runs; this is the only reference, since a new one cannot begin while it lives
        demand = pylibfranka.RealtimeConfig.kEnforce if enforced else pylibfranka.RealtimeConfig.kIgnore
        with self._named_errors(f"no connection to a Franka at {address}"):
            self._robot = pylibfranka.Robot(address, demand)
            state = self._robot.read_once()
        if robot is not None:
            T_base_ee, T_flange_ee = (np.array(each).reshape(4, 4).T for each in (state.O_T_EE, state.F_T_EE))
            refuse_another_robot(robot, state.q, T_base_ee @ inverse(T_flange_ee))
            self.joint_names = tuple(robot.joint_names)

    @property
    def q(self) -> Array:
        """The measured joint positions [rad], shape (7,).

        Raises:
            ArmConnectionError: The connection was lost.
        """
        if self._measured is not None:
            return self._measured.copy()
        with self._named_errors("the arm's state cannot be read"):
            return np.array(self._robot.read_once().q)

    def run(self, motion: Trajectory, *, speed: float = 1.0) -> Record:
        """Follow a motion at 1 kHz; returns when it has ended or ``stop`` was called; see ``Arm.run``.

        First the arm moves to the motion's start, in 0.2 s, from its commanded position: at most twice ``start_tolerance`` away.

        Raises:
            InputError: The motion or the speed is refused. The arm has not moved.
            ArmConnectionError: The connection was lost; the controller stops the arm then.
            ArmError: The controller has stopped the arm, or does not let it move; or the driver stopped it, since a joint was
                more than 0.1 rad from all commands of the last 0.2 s. The error contains the controller's words and the arm's
                position.
        """
        self._stop.clear()
        if self.joint_names is not None and isinstance(motion, Trajectory) and motion.joint_names != self.joint_names:
            raise InputError("motion", f"its joints are {motion.joint_names}, and the robot's are {self.joint_names}")
        state = self._idle_state()
        body = commands_of(motion, self.model, np.array(state.q), speed=speed, tolerance=self._tolerance)
        self._refuse_unless_idle(state)
        return self._follow(body, motion.joint_names, goal=motion.q[-1])

    def follow(self, servo: Servo, goal: Goal) -> Record:
        """Steer the arm by a servo at 1 kHz; see ``Arm.follow``.

        It starts at the controller's commanded position. A missed period counts as a tick too, so that the arm continues at the
        certified speed.

        Args:
            servo: A servo with a rate of 1000, and with ``jerk=`` or at most 2.5 rad/s^2: without ``jerk=`` a tick has a constant
                acceleration.
            goal: A function of the time [s] and of the measured q, shape (7,). It returns the arguments of ``Servo.step``, as
                {"pose": T}; None brings the arm to rest, which ends the run. It is called each millisecond, and may take a part
                of it.

        Returns:
            The commands and the measured positions.

        Raises:
            InputError: The servo is refused, or the arm's position is not certified free. The arm has not moved.
            ArmConnectionError: The connection was lost; the controller stops the arm then.
            ArmError: The controller has stopped the arm, or does not let it move.
        """
        self._stop.clear()
        steering, state = Steering(servo, self.model, goal), self._idle_state()
        if self.joint_names is not None and servo.joint_names != self.joint_names:
            raise InputError("servo", f"its joints are {servo.joint_names}, and the robot's are {self.joint_names}")
        steering.begin(np.array(state.q_d))
        servo.warm_up()
        self._refuse_unless_idle(state)
        return self._follow(np.array(state.q_d)[None], servo.joint_names, steering)

    def _idle_state(self) -> Any:
        """The controller's state; raises an error while a motion runs."""
        if self._measured is not None:
            raise ArmError("another motion is running")
        with self._named_errors("the arm's state cannot be read"):
            return self._robot.read_once()

    def _refuse_unless_idle(self, state: Any) -> None:
        if state.robot_mode != self._client.RobotMode.Idle:
            words = f"{state.robot_mode.name} {state.current_errors}".strip()
            raise ArmError("the arm cannot move; free it, or call arm.recover() after a reflex", words, state.q)

    def stop(self) -> None:
        """Stop a motion that runs in another thread, by the controller's own stop, which leaves the path slightly."""
        self._stop.set()

    def recover(self) -> None:
        """Clear the errors after a reflex, so that the arm can move again. It does not move.

        Raises:
            ArmError: The controller refuses.
            ArmConnectionError: The connection was lost.
        """
        with self._named_errors("the arm does not recover"):
            self._robot.automatic_error_recovery()

    def close(self) -> None:
        """End the connection. The thread of a running motion stops it first."""
        self._closing = True
        self.stop()
        if self._measured is None:
            self._robot = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _follow(
        self, body: Array, names: tuple[str, ...], steering: Steering | None = None, *, goal: Array | None = None
    ) -> Record:
        """Send a command for each state, until the end of ``body``, shape (n, 7), or of the steering."""
        sent: _Sent = []
        collecting = gc.isenabled()
        try:
            gc.disable()  # a collection may take longer than a period
            with self._named_errors("the arm has stopped by itself", sent, names):
                self._measured = body[0]
                self._control = self._robot.start_joint_position_control(self._client.ControllerMode.JointImpedance)
                stopped = self._send(body, sent, names, steering)
        except BaseException as error:
            if not isinstance(error, ArmError):  # above all for Ctrl-C: the arm must not go on
                self._robot.stop()
            raise
        finally:
            self._measured = self._control = None
            if self._closing:
                self._robot = None
            if collecting:
                gc.enable()
        found = _record(sent, names, stopped=stopped)
        where = self._where(sent)
        return replace(
            found,
            goal=found.goal if goal is None else np.array(goal),
            q_end=np.array(where) if where else found.q_end,
            arrival=self.model.arrival,
        )

    def _send(self, body: Array, sent: _Sent, names: tuple[str, ...], steering: Steering | None) -> bool:
        """Send ``body`` or the servo's commands in time, and append each to ``sent``; returns whether it was stopped."""
        client, tick, commands = self._client, 0, []
        recent = np.repeat(body[:1], round(self.model.lag / PERIOD), axis=0)
        while True:
            state, passed = self._control.readOnce()
            tick += round(passed.to_sec() / PERIOD)
            if not commands:  # start from the controller's current command
                q, tick = np.array(state.q_d), 0
                if not np.abs(q - body[0]).max() <= 2 * self._tolerance:
                    self._robot.stop()
                    raise ArmError("the controller's commanded position is not the measured one; nothing was sent", "", state.q)
                recent[:] = q
                if steering is not None:
                    steering.begin(q)
                    commands = [q.tolist()]
                else:
                    commands = np.concatenate([approach(q, body[0]), body, _hold(body[-1])]).tolist()
            self._measured = np.array(state.q)
            low, high = recent.min(axis=0), recent.max(axis=0)
            off = np.maximum(low - self._measured, self._measured - high)  # distance from all recent commands
            joint = int(np.argmax(off))
            if not off[joint] <= self.model.deviation:
                self._robot.stop()
                held = f"{names[joint]} is {off[joint]:.2g} rad from all commands of the last {self.model.lag:g} s"
                raise ArmError(f"{held}, as if something blocks the arm: it was stopped", "", state.q, _record(sent, names))
            if self._stop.is_set():
                self._robot.stop()
                return True
            while steering is not None and len(commands) <= tick and not steering.ended:
                commands.append(steering.step(self._measured).tolist())
                if steering.ended:
                    commands += _hold(commands[-1]).tolist()
            k = min(tick, len(commands) - 1)
            sent.append((tick, commands[k], state.q))
            recent[len(sent) % len(recent)] = commands[k]
            command = client.JointPositions(commands[k])
            command.motion_finished = k == len(commands) - 1 and (steering is None or steering.ended)
            self._control.writeOnce(command)
            if command.motion_finished:
                return False

    @contextmanager
    def _named_errors(self, message: str, sent: _Sent | None = None, names: tuple[str, ...] = ()) -> Iterator[None]:
        """Within the block, convert the client's errors to Ulna's, with the client's words and the arm's position."""
        client = self._client
        if self._robot is None:
            raise ArmConnectionError("the connection was closed")
        try:
            yield
        except client.NetworkException as error:
            record = _record(sent, names) if sent else None
            self._control = None
            message = "the connection was lost while the arm moved" if sent else message
            raise ArmConnectionError(message, str(error), sent[-1][2] if sent else (), record) from error
        except (
            client.ControlException,
            client.CommandException,
            client.InvalidOperationException,
            client.RealtimeException,
        ) as error:
            record = _record(sent, names) if sent else None
            self._control = None
            raise ArmError(message, str(error), self._where(sent), record) from error
        except RuntimeError as error:  # the client lets some errors of its network library through
            if sent is not None or isinstance(error, ArmError):
                raise
            raise ArmConnectionError(message, str(error)) from error

    def _where(self, sent: _Sent | None) -> list[float]:
        """The measured position of the arm, or the last one."""
        try:
            return self._robot.read_once().q
        except Exception:  # noqa: BLE001 - another error is being raised: after any failure here, the last position is used
            return sent[-1][2] if sent else []


def _hold(q: ArrayLike) -> Array:
    """Repeat the last command, shape (n, 7)."""
    return np.repeat(np.array(q)[None], round(_HOLD / PERIOD), axis=0)


def _record(sent: _Sent, names: tuple[str, ...], *, stopped: bool = False) -> Record:
    ticks = np.array([tick for tick, _, _ in sent], dtype=np.int64)
    commanded, measured = (np.array([row[k] for row in sent]).reshape(-1, len(names)) for k in (1, 2))
    lost = int(np.maximum(np.diff(ticks) - 1, 0).sum())
    return Record(PERIOD * ticks.astype(np.float64), commanded, measured, names, stopped, lost)
