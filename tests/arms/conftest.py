"""A client of a Franka without a Franka: what is commanded is measured one tick later."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import ulna

HOME = np.array([0.0, -0.7, 0.0, -2.3, 0.0, 1.6, 0.8])
LOWER = np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159])


class ControlException(RuntimeError): ...


class NetworkException(RuntimeError): ...


class CommandException(RuntimeError): ...


class InvalidOperationException(RuntimeError): ...


class RealtimeException(RuntimeError): ...


class Mode:
    def __init__(self, name):
        self.name = name


class Controller:
    """The other side: ``fail_at`` raises ``failure`` at a tick, ``skip_at`` loses three periods."""

    Idle, Reflex = Mode("Idle"), Mode("Reflex")

    def __init__(self):
        self.q, self.q_d, self.mode, self.commands, self.calls = HOME.copy(), HOME.copy(), self.Idle, [], []
        self.fail_at = self.failure = self.skip_at = self.at_tick = None

    def state(self):
        flange = ulna.load("panda").forward_kinematics(self.q, link="panda_link8")
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

    def readOnce(self):
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

    def writeOnce(self, command):
        self.controller.commands.append(command)
        self.controller.q = self.controller.q_d = np.array(command.q)


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
                raise NetworkException("libfranka: Connection timeout")

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
    for each in (ControlException, NetworkException, CommandException, InvalidOperationException, RealtimeException, Robot, JointPositions):
        setattr(client, each.__name__, each)
    client.RobotMode = Controller
    client.RealtimeConfig = SimpleNamespace(kEnforce="enforce", kIgnore="ignore")
    client.ControllerMode = SimpleNamespace(JointImpedance="impedance")
    monkeypatch.setitem(sys.modules, "pylibfranka", client)
    return found


@pytest.fixture(scope="session")
def arm_robot():
    """The Panda with the limits of the FR3, whose kinematics are the same."""
    upper = np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159])
    text = ulna.load("panda").description
    joints = []
    from dataclasses import replace

    for joint in text.joints:
        if joint.name[-1:].isdigit() and joint.name != "panda_joint8":
            k = int(joint.name[-1]) - 1
            limits = replace(joint.limits, lower=LOWER[k], upper=upper[k])
            joint = replace(joint, limits=limits)
        joints.append(joint)
    return ulna.Robot(replace(text, joints=tuple(joints)))


@pytest.fixture
def motion_to(arm_robot):
    """Makes the motion from q to a goal."""

    def make(q, change, **limits):
        goal = np.array(q) + change
        plan = arm_robot.plan(q, goal, ulna.World())
        assert plan
        return plan.trajectory(**({"velocity": 1.0, "acceleration": 5.0, "jerk": 2000.0} | limits))

    return make
