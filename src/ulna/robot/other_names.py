"""Maps method names of other libraries to Ulna's: each raises an ``AttributeError`` that names the call to write."""

from collections.abc import Iterable
from typing import Never

_FORWARD, _INVERSE, _JACOBIAN = "robot.forward_kinematics(q)", "robot.inverse_kinematics(T_base_tip)", "robot.jacobian(q)"
_LIMITS = "robot.lower and robot.upper"
_INVERSE_DYNAMICS, _FORWARD_DYNAMICS = "robot.inverse_dynamics(q, qd, qdd)", "robot.forward_dynamics(q, qd, torque)"
_MASS_MATRIX = "robot.mass_matrix(q)"
OTHER_NAMES = {  # from Robotics Toolbox, Pinocchio, PyBullet, MoveIt, urdfpy and others
    "fk": _FORWARD,
    "fkine": _FORWARD,
    "forward": _FORWARD,
    "link_fk": "robot.link_poses(q)",
    "ik": _INVERSE,
    "ikine": _INVERSE,
    "ikine_LM": _INVERSE,
    "ikine_a": "robot.all_solutions(T_base_tip)",
    "inverse": _INVERSE,
    "jacob0": _JACOBIAN,
    "jacobe": 'robot.jacobian(q, expressed_in="link")',
    "jacob": _JACOBIAN,
    "rnea": _INVERSE_DYNAMICS,
    "rne": _INVERSE_DYNAMICS,
    "aba": _FORWARD_DYNAMICS,
    "accel": _FORWARD_DYNAMICS,
    "crba": _MASS_MATRIX,
    "inertia": _MASS_MATRIX,
    "gravload": "robot.gravity_torque(q)",
    "coriolis": "robot.coriolis_torque(q, qd)",
    "qlim": _LIMITS,
    "joint_limits": _LIMITS,
    "limits": _LIMITS,
    "n": "robot.n_dof",
    "nq": "robot.n_dof",
    "dof": "robot.n_dof",
    "num_joints": "robot.n_dof",
    "joints": "robot.joint_names, or robot.description.joints",
    "links": "robot.link_names, or robot.description.links",
    "qz": "robot.home",
    "neutral": "robot.home",
    "iscollided": "robot.in_collision(q, world)",
    "is_collision_free": "not robot.in_collision(q, world)",
    "plot": "robot.show(q), or ulna.view(robot)",
    "teach": "ulna.view(robot)",
}


class OtherName:
    """A descriptor for a name that a class lacks: access raises an error that names the replacement.

    A ``__getattr__`` instead would make every method call some 50 ns slower. ``hasattr`` is False.
    """

    def __init__(self, name: str, instead: str) -> None:
        self.name, self.instead = name, instead

    def __get__(self, instance: object, owner: type | None = None) -> Never:
        """Raise the error that names the replacement."""
        raise AttributeError(f"a Robot has no {self.name!r}; write {self.instead}", name=self.name, obj=instance)


def put_other_names(of: type) -> None:
    """Add an ``OtherName`` to a class for each name of ``OTHER_NAMES`` that the class lacks."""
    for name, instead in OTHER_NAMES.items():
        if not hasattr(of, name):
            setattr(of, name, OtherName(name, instead))


def without_other_names(names: Iterable[str]) -> list[str]:
    """The given names, as from ``dir``, without those in ``OTHER_NAMES``."""
    return [name for name in names if name not in OTHER_NAMES]
