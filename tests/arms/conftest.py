"""A client of a Franka without a Franka: what is commanded is measured one tick later."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import ulna

ERRORS = ("ControlException", "NetworkException", "CommandException", "InvalidOperationException", "RealtimeException")


class Mode:
    def __init__(self, name):
        self.name = name


class Controller:
    """The other side. At a tick ``failure`` is raised, three periods are lost, or a function is called."""

    Idle, Reflex = Mode("Idle"), Mode("Reflex")

    def __init__(self):
        self.q, self.q_d, self.mode, self.commands, self.calls = *ulna.load("fr3").home[None].repeat(2, 0), self.Idle, [], []
        self.moved = np.eye(4)  # the flange, from where the description has it
        self.fail_at = self.failure = self.skip_at = self.at_tick = None
        self.held = False  # whether something keeps the arm where it is
        self.behind = 0  # how many ticks the arm is behind its commands
        self.floor = None  # the greatest position that every joint reaches
        self.late = []  # commands that the arm is behind, the oldest first

    def state(self):
        flange = ulna.load("fr3").forward_kinematics(self.q, link="fr3_link8") @ self.moved
        return SimpleNamespace(
            q=self.q.tolist(),
            q_d=self.q_d.tolist(),
            robot_mode=self.mode,
            current_errors="[]" if self.mode is self.Idle else '["a_reflex"]',
            O_T_EE=flange.T.ravel().tolist(),
            F_T_EE=np.eye(4).ravel().tolist(),
        )


class Control:
    def __init__(self, controller):
        self.controller, self.ticks = controller, 0

    def readOnce(self):  # noqa: N802 - the client's name
        controller = self.controller
        if controller.fail_at == self.ticks:
            controller.mode = Controller.Reflex
            raise controller.failure
        if controller.at_tick and self.ticks == controller.at_tick[0]:
            controller.at_tick[1]()
        state = controller.state() if self.ticks == 0 else SimpleNamespace(q=controller.q.tolist(), q_d=controller.q_d.tolist())
        passed = 0.0 if self.ticks == 0 else 0.004 if controller.skip_at == self.ticks else 0.001
        self.ticks += 1
        return state, SimpleNamespace(to_sec=lambda: passed)

    def writeOnce(self, command):  # noqa: N802 - the client's name
        self.controller.commands.append(command)
        self.controller.q_d = np.array(command.q)
        controller = self.controller
        if not controller.held:
            controller.late.append(controller.q_d)
            controller.q = controller.late[0] if len(controller.late) <= controller.behind else controller.late.pop(0)
            controller.q = controller.q if controller.floor is None else np.minimum(controller.q, controller.floor)


class JointPositions:
    def __init__(self, q):
        self.q, self.motion_finished = q, False


@pytest.fixture
def controller(monkeypatch):
    found = Controller()

    class Robot:
        def __init__(self, address, realtime):
            found.calls.append((address, realtime))
            if address == "10.0.0.9":
                raise client.NetworkException("libfranka: Connection timeout")

        def read_once(self):
            return found.state()

        def start_joint_position_control(self, mode):
            found.calls.append(mode)
            return Control(found)

        def stop(self):
            found.calls.append("stop")

        def automatic_error_recovery(self):
            found.calls.append("recover")
            found.mode = Controller.Idle

    client = ModuleType("pylibfranka")
    for name in ERRORS:
        setattr(client, name, type(name, (RuntimeError,), {}))
    client.Robot, client.JointPositions = Robot, JointPositions
    client.RobotMode = Controller
    client.RealtimeConfig = SimpleNamespace(kEnforce="enforce", kIgnore="ignore")
    client.ControllerMode = SimpleNamespace(JointImpedance="impedance")
    monkeypatch.setitem(sys.modules, "pylibfranka", client)
    return found


@pytest.fixture(scope="session")
def fr3():
    return ulna.load("fr3")


@pytest.fixture
def motion_to(fr3):
    """Makes the motion from q to a goal."""

    def make(q, change, **limits):
        goal = np.array(q) + change
        plan = fr3.plan(q, goal, None)
        assert plan
        return plan.trajectory(**({"velocity": 1.0, "acceleration": 5.0, "jerk": 2000.0} | limits))

    return make
