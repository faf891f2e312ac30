"""Reads MJCF, the models of MuJoCo: converts the tables of MuJoCo's compiler to links, joints and shapes.

It compiles in a child process, with limits of time and memory (``mjcf_child``).
"""

import json
import math
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.document import Document
from ulna.description.pose import inverse, pose
from ulna.description.robot_description import Body, Description, Inertia, Joint, JointType, LeftOut, Limits, Link, Mimic
from ulna.description.shapes import Box, Capsule, ConvexMesh, Cylinder, Shape, Sphere, UnknownShape
from ulna.errors import DescriptionError, needs_extra

Array = NDArray[np.float64]
TIME_LIMIT_S = 30.0
MEMORY_LIMIT_BYTES = 4 << 30
_COEFFICIENTS = 5  # of the polynomial of an equality of two joints


def read_mjcf(document: Document) -> Description:
    """The description in an MJCF document.

    A body is a link; the world is the root, ``world``. An extra link without shapes precedes each further joint of a body, and a
    body whose joint is not at its origin. Shapes without contacts are visuals. A mesh is its convex hull, as in MuJoCo's own
    collision checking.

    Raises:
        DescriptionError: MuJoCo refuses it, or its joints do not form a tree: a ball joint, a tendon that limits or pulls, an
            equality that closes a loop. The error names it.
        MissingExtraError: MuJoCo is not installed.
    """
    with needs_extra("reading MJCF", "mujoco", "mujoco"):
        mujoco = import_module("mujoco")  # its types differ between versions
    content = _compiled(document)
    model = mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": content})
    return _Reader(document, model, mujoco).description()


def _compiled(document: Document) -> bytes:
    """The compiled model, in MuJoCo's own binary form."""
    from ulna.description.child_process import child_process, last_words, printable  # noqa: PLC0415 - as for xacro
    from ulna.engine.child_program import program_of  # noqa: PLC0415

    path = None if document.folder is None else str((document.folder / document.file).resolve())
    try:
        request = json.dumps({"path": path, "text": None if path else document.text.decode()}).encode()
    except UnicodeDecodeError as error:
        raise DescriptionError(f"it is not UTF-8 ({error.reason})", document.source) from None
    with child_process(program_of("ulna.description.mjcf_child"), MEMORY_LIMIT_BYTES, TIME_LIMIT_S) as (child, late):
        replied, errors = child.communicate(request)
        if late.is_set():
            raise DescriptionError(f"MuJoCo: not finished within {TIME_LIMIT_S:g} s; compilation stopped", document.source)
        line, _, content = replied.partition(b"\n")
        if not line:
            words = f"{last_words(child, errors)}; it may use {MEMORY_LIMIT_BYTES >> 20} MB"
            raise DescriptionError(f"MuJoCo: the compilation died ({words})", document.source)
    reply = json.loads(line)
    if "error" in reply:
        raise DescriptionError(f"MuJoCo: {printable(reply['error'])}", document.source)
    return content


class _Reader:
    """Reads one compiled model."""

    def __init__(self, document: Document, model: Any, mujoco: ModuleType) -> None:
        self.document, self.model, self.mujoco = document, model, mujoco
        self.followers = self.equalities()
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.left_out: list[LeftOut] = []

    def fail(self, message: str) -> DescriptionError:
        return DescriptionError(message, self.document.source)

    def name(self, kind: str, number: int) -> str:
        """The name of an object, such as a body or a joint, or a name made of its number."""
        if kind == "body" and number == 0:
            return "world"
        enum = getattr(self.mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
        return self.mujoco.mj_id2name(self.model, enum, number) or f"{kind}_{number}"

    def description(self) -> Description:
        model = self.model
        self.refuse_tendons()
        self.links.append(Link("world", *self.bodies(0)))
        for body in range(1, model.nbody):
            self.add(body)
        if np.any(model.dof_armature):
            message = "armature, the inertia of rotors, is not read: no torque includes it"
            self.left_out.append(LeftOut("document", message, is_warned=False, is_note=True))
        xml_name = self.document.root.get("model", "")
        return Description(
            name=xml_name or "MuJoCo Model",
            links=tuple(self.links),
            joints=tuple(self.joints),
            source=self.document.source,
            folder=self.document.folder,
            package_dirs=self.document.package_dirs,
            left_out=tuple(self.left_out),
        )

    def refuse_tendons(self) -> None:
        """Refuse tendons that constrain joints; a tendon that only transmits an actuator moves no link by itself."""
        model = self.model
        for k in range(model.ntendon):
            is_spatial = any(
                model.wrap_type[w] != self.mujoco.mjtWrap.mjWRAP_JOINT
                for w in range(model.tendon_adr[k], model.tendon_adr[k] + model.tendon_num[k])
            )
            if is_spatial or model.tendon_limited[k] or np.any(model.tendon_stiffness[k]):
                raise self.fail(f"tendon {self.name('tendon', k)!r} couples joints, which is not a tree of joints")

    def equalities(self) -> dict[int, tuple[int, float, float]]:
        """For each joint that follows another: the other, the ratio, and its position when the other is at 0."""
        model, kinds, followers = self.model, self.mujoco.mjtEq, {}
        for k in range(model.neq):
            if not model.eq_active0[k]:
                continue
            name = self.name("equality", k)
            if model.eq_type[k] != kinds.mjEQ_JOINT:
                raise self.fail(f"equality {name!r} closes a loop of bodies, which is not a tree of joints")
            constant, ratio, *higher = model.eq_data[k, :_COEFFICIENTS].tolist()
            one, other = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
            if other < 0 or any(higher):
                raise self.fail(f"equality {name!r} of joints is not linear in one other joint")
            at_rest = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (one, other))
            rest_one, rest_other = at_rest
            followers[one] = other, ratio, rest_one + constant - ratio * rest_other
        return followers

    def add(self, body: int) -> None:
        """Add the link of a body, with its joints."""
        model, name = self.model, self.name("body", body)
        parent = self.name("body", int(model.body_parentid[body]))
        place = pose(model.body_pos[body], wxyz=model.body_quat[body])
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        joints = list(range(first, first + count)) if count else []
        for k, number in enumerate(joints):
            kind = model.jnt_type[number]
            at = pose(model.jnt_pos[number])
            is_last = k == len(joints) - 1 and (np.array_equal(at, np.eye(4)) or kind == self.mujoco.mjtJoint.mjJNT_SLIDE)
            child = name if is_last else f"{name}_at_{self.name('joint', number)}"
            if kind == self.mujoco.mjtJoint.mjJNT_SLIDE:
                at = np.eye(4)  # a prismatic joint has no place
            if kind == self.mujoco.mjtJoint.mjJNT_FREE:
                place, at, child = np.eye(4), np.eye(4), name
            self.joints.append(self.joint(number, parent, child, place @ at))
            if child != name:
                self.links.append(Link(child))
            place, parent = inverse(at), child
        if parent != name:
            z = np.array([0.0, 0.0, 1.0])
            self.joints.append(Joint(f"{name}_fixed", JointType.FIXED, parent, name, place, z))
        self.links.append(Link(name, *self.bodies(body), inertia=self.inertia(body)))

    def joint(self, number: int, parent: str, child: str, origin: Array) -> Joint:
        """One joint with MuJoCo's positions: at the position of the reference configuration its rotation is 0."""
        model, kinds, name = self.model, self.mujoco.mjtJoint, self.name("joint", number)
        kind, z = model.jnt_type[number], np.array([0.0, 0.0, 1.0])
        if kind == kinds.mjJNT_FREE:
            return Joint(name, JointType.FLOATING, parent, child, origin, z)
        if kind == kinds.mjJNT_BALL:
            raise self.fail(f"joint {name!r} is a ball joint, which is not supported; three hinges are")
        axis, rest = model.jnt_axis[number], float(model.qpos0[model.jnt_qposadr[number]])
        lower, upper = model.jnt_range[number].tolist() if model.jnt_limited[number] else (-math.inf, math.inf)
        effort = float(model.jnt_actfrcrange[number].max()) if model.jnt_actfrclimited[number] else math.inf
        if kind == kinds.mjJNT_SLIDE:
            known, back = JointType.PRISMATIC, pose(-rest * axis)
        else:
            known, back = JointType.REVOLUTE if model.jnt_limited[number] else JointType.CONTINUOUS, pose(rotvec=-rest * axis)
        mimic = None
        if number in self.followers:
            other, ratio, offset = self.followers[number]
            mimic = Mimic(self.name("joint", other), ratio, offset)
        limits, dof = Limits(lower, upper, effort=effort), int(model.jnt_dofadr[number])
        damping, friction = (float(np.ravel(each[dof])[0]) for each in (model.dof_damping, model.dof_frictionloss))
        return Joint(name, known, parent, child, origin @ back, axis, limits, mimic, damping=damping, friction=friction)

    def inertia(self, body: int) -> Inertia | None:
        """The inertia of a body, in its axes; None without mass, as for a frame."""
        model, mass = self.model, float(self.model.body_mass[body])
        place = pose(model.body_ipos[body], wxyz=model.body_iquat[body])
        return Inertia(mass, np.zeros(3), np.diag(model.body_inertia[body])).moved(place) if mass else None

    def bodies(self, body: int) -> tuple[tuple[Body, ...], tuple[Body, ...]]:
        """The visuals and the collision shapes of a body."""
        model, visuals, collisions = self.model, [], []
        first = int(model.body_geomadr[body])
        for number in range(first, first + int(model.body_geomnum[body])):
            shape = self.shape(number)
            color = tuple(map(float, model.geom_rgba[number]))
            one = Body(
                self.name("geom", number),
                shape,
                pose(model.geom_pos[number], wxyz=model.geom_quat[number]),
                color,  # type: ignore[arg-type]
            )
            touches = bool(model.geom_contype[number] or model.geom_conaffinity[number])
            if isinstance(shape, UnknownShape) and (body == 0 or not touches):
                message = f"geom {one.name!r} is {shape.kind}, which is not supported: it is left out"
                self.left_out.append(LeftOut(f"link {self.name('body', body)!r}", message))
            else:
                (collisions if touches else visuals).append(one)
        return tuple(visuals), tuple(collisions)

    def shape(self, number: int) -> Shape:
        model, kinds = self.model, self.mujoco.mjtGeom
        a, b, c = model.geom_size[number].tolist()
        match model.geom_type[number]:
            case kinds.mjGEOM_SPHERE:
                return Sphere(a)
            case kinds.mjGEOM_CAPSULE:
                return Capsule(a, 2 * b)
            case kinds.mjGEOM_CYLINDER:
                return Cylinder(a, 2 * b)
            case kinds.mjGEOM_BOX:
                return Box((2 * a, 2 * b, 2 * c))
            case kinds.mjGEOM_MESH:
                mesh = int(model.geom_dataid[number])
                first = int(model.mesh_vertadr[mesh])
                return ConvexMesh(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].astype(np.float64))
            case other:
                return UnknownShape(f"a {kinds(int(other)).name.removeprefix('mjGEOM_').lower()}")
