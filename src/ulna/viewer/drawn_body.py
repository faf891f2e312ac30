"""Draws a robot without visuals from its joints alone: shells, dark joints, and a hand with fingers.

A link is a smooth union of tapered legs and of housings around its joints: a signed distance, which is then meshed. Two links
meet in one of three forms. If the child continues along the joint axis, there are two shells with a dark ring between them
(``"inline"``). If it leaves the axis, there is a hinge: a fork and a tongue on a dark pin. A slide is drawn on a rail.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.geometry import align_vectors
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from ulna.description.robot_description import Body, Joint, JointType
from ulna.description.shapes import Box, Capsule, Cylinder, Sphere
from ulna.robot import Robot
from ulna.viewer.surface_nets import Distance, Vector, box, cone, cut, drum, mesh_of, union

SHELL, DARK, PAD = (236, 238, 241, 255), (66, 72, 82, 255), (120, 128, 140, 255)  # colors of shells, joints, fingers
_NARROWEST = 0.6  # the radius at the tip, relative to the base
_MANY_JOINTS = 10  # a robot with at least as many joints has several chains: it is drawn thinner and in less detail
_WAIST, _SLIMMEST = 0.92, 0.6  # the largest and the smallest radius of a leg, relative to its joint
_GAP = 0.09  # between two shells, relative to the radius
_TURNING = (JointType.REVOLUTE, JointType.CONTINUOUS)
_FARTHEST = 2.0  # [m] the maximum drawn travel of a slide from its zero
_NEAR = 0.5  # [radii] a shorter leg is not drawn
_PARALLEL = 0.99  # the minimum cosine between parallel axes


@dataclass(frozen=True)
class _Leg:
    """The path from a link's origin to a child's: to the nearest point of its axis, then along the axis.

    Lengths are in m, vectors in the axes of the link.
    """

    joint: Joint
    axis: Vector  # the axis of the child's joint
    end: Vector  # the child's origin
    foot: Vector  # the point of the axis nearest to the link's origin

    @property
    def along(self) -> float:
        """The signed length along the axis, from the foot to the child's origin."""
        return float((self.end - self.foot) @ self.axis)


@dataclass(frozen=True)
class _DrawnJoint:
    """The joint between two drawn links.

    Attributes:
        kind: ``"inline"``, ``"hinge"``, ``"slide"``; empty for a fixed joint.
        radius: The radius of the shells at the joint [m].
        at: For ``"inline"``, the coordinate along the axis at which the shells meet, from the child's origin [m].
        ahead: For ``"inline"``, 1 if the child is ahead of the parent in the direction of the axis, else -1.
        straight: Whether the child continues along the axis.
        offset: The coordinate along the axis at which the child's body runs, from the child's origin [m].
    """

    kind: str
    radius: float
    at: float = 0.0
    ahead: float = 1.0
    straight: bool = False
    offset: float = 0.0


def drawn_body(robot: Robot) -> dict[str, trimesh.Scene]:
    """The drawn body of each link that has one, in its own frame."""
    return _Drawing(robot).scenes()


class _Drawing:
    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._carriers = {joint.child: joint for joint in robot.description.joints}
        self._legs: dict[str, list[_Leg]] = {link: [] for link in robot.link_names}
        for joint in robot.description.joints:
            self._legs[joint.parent].append(_leg(joint))
        self._drawn_joints = {joint.child: self._join(joint) for joint in robot.description.joints}

    def scenes(self) -> dict[str, trimesh.Scene]:
        bodies = {link: self._body(link) for link in self._robot.link_names}
        return {link: merge_parts(parts) for link, parts in bodies.items() if parts}

    # ---- sizes and joints -----------------------------------------------------------------------------------------------

    @cached_property
    def _thickness(self) -> float:
        """The radius at the base [m], from the length of the robot and the widths of its collision shapes."""
        robot = self._robot
        lengths = sum(float(np.linalg.norm(joint.origin[:3, 3])) for joint in robot.description.joints) or 1.0
        usual = (0.05 if robot.n_dof < _MANY_JOINTS else 0.02) * lengths
        widths = [
            radius / self._taper(link.name)
            for link in robot.description.links
            if robot.tree.link_row[link.name] >= 0
            for radius in map(_half_width, link.collisions)
            if radius
        ]
        largest = (1.6 if robot.n_dof < _MANY_JOINTS else 1.0) * usual
        return float(np.clip(np.median(widths), 0.5 * usual, largest)) if widths else usual

    def _taper(self, link: str) -> float:
        """The factor of a link's radius: 1 at the base, _NARROWEST at the end of the longest chain."""
        tree = self._robot.tree
        deepest = max(len(tree.chain(leaf)) for leaf in tree.leaves)
        return 1.0 - (1.0 - _NARROWEST) * len(tree.chain(link)) / deepest

    def _onward(self, link: str) -> Vector:
        """The first leg of a link longer than 0, in the axes of the link [m]; zeros without one."""
        legs = sorted(self._legs[link], key=lambda leg: -float(np.linalg.norm(leg.end)))
        for leg in legs:
            if (length := np.linalg.norm(leg.end)) > 1e-3 * self._thickness:
                aside = np.linalg.norm(leg.foot) > max(_NEAR * self._thickness * self._taper(link), 1e-2 * length)
                return leg.foot if aside and leg.joint.type in _TURNING else leg.end
        for leg in legs:
            if (further := self._onward(leg.joint.child)).any():
                return leg.joint.origin[:3, :3] @ further
        return np.zeros(3)

    def _join(self, joint: Joint) -> _DrawnJoint:
        leg, onward = _leg(joint), self._onward(joint.child)
        longest = max(float(np.linalg.norm(one.end)) for one in (leg, *self._legs[joint.child]))
        radius = self._thickness * self._taper(joint.child)
        radius = min(radius, 0.5 * longest) if longest > 0.0 else radius
        if joint.type == JointType.PRISMATIC:
            return _DrawnJoint("slide", radius)
        if joint.type not in _TURNING:
            return _DrawnJoint("", radius)
        length, offset = float(np.linalg.norm(onward)), self._body_offset(joint.child, radius)
        cosine = float(onward @ _unit(joint.axis)) / length if length > 0.0 else 0.0
        straight = abs(cosine) > 0.7
        carrier = self._carriers.get(joint.parent)
        before = -leg.along
        if carrier is not None and abs(side := float(_unit(carrier.axis) @ leg.axis)) > _PARALLEL:
            before += side * self._body_offset(joint.parent, radius)
        if abs(offset - before) >= radius:
            ahead = float(np.sign(offset - before))
            goes_on = straight and cosine * ahead > 0
            return _DrawnJoint("inline", radius, (before + offset) / 2, ahead, goes_on, offset)
        if straight:
            ahead = float(np.sign(cosine))
            return _DrawnJoint("inline", radius, ahead * min(1.15 * radius, length / 2), ahead, straight=True)
        if not length:
            return _DrawnJoint("inline", radius, 0.9 * radius, 1.0)
        return _DrawnJoint("hinge", radius)

    def _body_offset(self, link: str, radius: float) -> float:
        """The offset of a link's body along its joint axis [m], for a link between parallel axes.

        It is 0 unless the collision shapes are far from the origin.
        """
        carrier = self._carriers.get(link)
        if carrier is None or carrier.type not in _TURNING:
            return 0.0
        axis = _unit(carrier.axis)
        parallel = [leg for leg in self._legs[link] if leg.joint.type in _TURNING and abs(leg.axis @ axis) > _PARALLEL]
        shapes = next(one.collisions for one in self._robot.description.links if one.name == link)
        if not shapes or not any(np.linalg.norm(leg.foot) > _NEAR * radius for leg in parallel):
            return 0.0
        offset = float(np.median([body.pose[:3, 3] @ axis for body in shapes]))
        return offset if abs(offset) > _NEAR * radius else 0.0

    # ---- the body of a link -----------------------------------------------------------------------------------------------

    def _body(self, link: str) -> list[trimesh.Trimesh]:
        carrier = self._carriers.get(link)
        own_joint = self._drawn_joints[link] if carrier is not None else _DrawnJoint("", self._thickness)
        shells: list[Distance] = []
        cuts: list[Distance] = []
        dark: list[trimesh.Trimesh] = []
        parts: list[trimesh.Trimesh] = []
        if self._stands(link):
            own_joint = _DrawnJoint("", 1.3 * self._thickness)
            up, r = np.array([0.0, 0.0, 1.0]), own_joint.radius
            if all(leg.end[2] >= 0.0 for leg in self._legs[link]):
                if carrier is None:
                    dark.append(_disc(np.zeros(3), up, (0.0, 0.2 * r), 1.2 * r))
                cuts.append(drum(-2.0 * r * up, up, 4.0 * r, 2.1 * r, 0.0))  # nothing below the foot
        elif carrier is not None:
            _add_near_end(own_joint, _unit(carrier.axis), shells, cuts, dark, leaf=not self._onward(link).any())
        for leg in self._legs[link]:
            child_joint = self._drawn_joints[leg.joint.child]
            if self._is_finger(leg.joint):
                shells.append(_palm(leg))
            elif self._is_hand(leg.joint):
                parts += _hand(leg.end, self._spread(link, leg.end))
            else:
                start = np.zeros(3) if carrier is None else own_joint.offset * _unit(carrier.axis)
                waist = self._waist(link, own_joint.radius)
                _add_leg(waist, start, leg, child_joint, shells, cuts, dark, leaf=not self._legs[leg.joint.child])
        if carrier is not None and self._is_finger(carrier):
            shells = [_finger(carrier)]
        size = min([own_joint.radius, *(self._drawn_joints[leg.joint.child].radius for leg in self._legs[link])])
        cell = (0.08 if self._robot.n_dof < _MANY_JOINTS else 0.14) * size
        body = mesh_of(cut(union(shells, 0.32 * size), cuts, 1.75 * cell), cell) if shells else None
        return parts + [paint_mesh(part, DARK) for part in dark] + ([] if body is None else [paint_mesh(body, SHELL)])

    def _waist(self, link: str, radius: float) -> float:
        """The radius of a link's legs [m]: at most that of its slimmest collision shape, which shall contain them."""
        shapes = next(one.collisions for one in self._robot.description.links if one.name == link)
        slimmest = min((width for width in map(_half_width, shapes) if width and not self._stands(link)), default=radius)
        return float(np.clip(0.97 * slimmest, _SLIMMEST * radius, _WAIST * radius))

    def _stands(self, link: str) -> bool:
        """Whether a link is the root, or fixed to the root at its origin with the same z axis."""
        carrier = self._carriers.get(link)
        if carrier is None:
            return True
        at_place = carrier.type == JointType.FIXED and np.allclose(carrier.origin[:, 2:], np.eye(4)[:, 2:])
        return at_place and self._stands(carrier.parent)

    def _is_hand(self, joint: Joint) -> bool:
        """Whether a joint leads from a flange to a tool point, so that a hand is drawn between them."""
        carrier = self._carriers.get(joint.parent)
        ends = joint.type == JointType.FIXED and not self._legs[joint.child] and len(self._legs[joint.parent]) == 1
        beyond = carrier is not None and carrier.type == JointType.FIXED and self._robot.tree.link_row[joint.parent] >= 0
        return ends and beyond and float(np.linalg.norm(joint.origin[:3, 3])) > self._drawn_joints[joint.child].radius

    def _is_finger(self, joint: Joint) -> bool:
        leg = _leg(joint)
        slides, aside = joint.type == JointType.PRISMATIC and not self._legs[joint.child], float(np.linalg.norm(leg.foot))
        return slides and aside > 1e-3 and float(np.ptp(_range(joint))) < 2 * aside

    def _spread(self, link: str, end: Vector) -> Vector:
        """The unit vector along which a hand's fingers open: the longer side of its collision box, or y."""
        robot, along = self._robot, _unit(end)
        places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
        spread, width = np.array([0.0, 1.0, 0.0]), 0.0
        for one in robot.description.links:
            for body in one.collisions if robot.tree.link_row[one.name] == robot.tree.link_row[link] else ():
                if isinstance(body.shape, Box):
                    T = np.linalg.inv(places[link]) @ places[one.name] @ body.pose
                    sides = [k for k in range(3) if abs(T[:3, k] @ along) < 0.1]
                    near = np.abs(T[:3, :3].T @ (0.5 * end - T[:3, 3])) <= body.shape.half_extents
                    for k in sides if near.all() else ():
                        if body.shape.half_extents[k] > width:
                            spread, width = T[:3, k], float(body.shape.half_extents[k])
        return _unit(spread - along * (spread @ along)) if width or abs(along[1]) < 0.9 else np.array([1.0, 0.0, 0.0])


def _leg(joint: Joint) -> _Leg:
    axis, end = joint.origin[:3, :3] @ _unit(joint.axis), joint.origin[:3, 3]
    foot = end - axis * (end @ axis) if joint.type in _TURNING or joint.type == JointType.PRISMATIC else end
    return _Leg(joint, axis, end, foot)


def _add_near_end(
    own_joint: _DrawnJoint, axis: Vector, shells: list[Distance], cuts: list[Distance], dark: list[trimesh.Trimesh], *, leaf: bool
) -> None:
    """Add the part of a link at its own joint."""
    r = own_joint.radius
    match own_joint.kind:
        case "inline":
            end = 0.0 if own_joint.straight else own_joint.offset + own_joint.ahead * 1.05 * r
            end = own_joint.at + own_joint.ahead * 0.7 * r if leaf else end
            body, onward = cone(axis * own_joint.at, axis * end, r, r), axis * own_joint.ahead
            if not own_joint.straight or leaf:
                body = _with_lid(body, axis * end, onward, r, cuts, dark)
            shells.append(body)
            cuts.append(_space_beyond(axis * own_joint.at, -onward, r, _GAP * r))
        case "hinge":
            big, half = 1.12 * r, 0.52 * r
            shells.append(drum(np.zeros(3), axis, big, half - _GAP * r, 0.1 * r))
            cuts += [drum(side * (half + 0.4 * r) * axis, axis, 1.05 * big, 0.4 * r, 0.0) for side in (-1.0, 1.0)]
        case "slide":
            shells.append(box(np.zeros(3), np.eye(3), np.full(3, 0.95 * r), 0.25 * r))


def _add_leg(
    start: float,
    begin: Vector,
    leg: _Leg,
    child_joint: _DrawnJoint,
    shells: list[Distance],
    cuts: list[Distance],
    dark: list[trimesh.Trimesh],
    *,
    leaf: bool,
) -> None:
    """Add the part of a link from its beginning to a child, and at the child's joint. start: the radius there [m]."""
    r = child_joint.radius
    end = min(start, _WAIST * r)
    aside = float(np.linalg.norm(leg.foot)) > _NEAR * r
    match child_joint.kind:
        case "inline":
            seam, onward = leg.end + leg.axis * child_joint.at, leg.axis * child_joint.ahead
            if aside:
                shells.append(cone(begin, begin + leg.foot, start, end))
                back = begin + leg.foot - 1.05 * r * onward
                shells.append(_with_lid(cone(back, seam, r, r), back, -onward, r, cuts, dark))
            else:
                shells.append(cone(begin, seam, start, r))
            cuts.append(_space_beyond(seam, onward, r, _GAP * r))
            dark.append(_disc(seam, leg.axis, (-0.3 * r, 0.3 * r), 0.92 * r))
        case "hinge":
            big, half, wide = 1.12 * r, 0.52 * r, 1.15 * r
            shells.append(cone(begin, leg.end, start, end))
            shells.append(drum(leg.end, leg.axis, big, wide, 0.2 * r))
            cuts.append(drum(leg.end, leg.axis, 1.07 * big, half + _GAP * r, 0.0))
            for side in (-1.0, 1.0):
                _lid(leg.end + leg.axis * side * wide, leg.axis * side, r, cuts, dark)
            dark.append(_disc(leg.end, leg.axis, (-0.95 * wide, 0.95 * wide), 0.9 * r))
        case "slide":
            low, high = _range(leg.joint)
            if aside or abs(leg.along) > _NEAR * r:
                shells.append(cone(np.zeros(3), leg.end, start, _WAIST * r))
            middle, half = leg.end + leg.axis * (low + high) / 2, (high - low) / 2 + 1.1 * r
            turn = _turn_to(leg.axis)
            dark.append(_box_mesh(middle, turn, np.array([0.55 * r, 0.55 * r, half])))
        case _ if np.linalg.norm(leg.end) > _NEAR * r:
            body = cone(np.zeros(3), leg.end, start, 0.85 * r)
            shells.append(_with_lid(body, leg.end, _unit(leg.end), 0.85 * r, cuts, dark) if leaf else body)


def _lid(place: Vector, out: Vector, radius: float, cuts: list[Distance], dark: list[trimesh.Trimesh]) -> None:
    """Add a dark lid in the end of a housing."""
    cuts.append(drum(place + 0.2 * radius * out, out, 0.84 * radius, 0.26 * radius, 0.0))
    dark.append(_disc(place, out, (-0.2 * radius, 0.0), 0.8 * radius))


def _with_lid(
    body: Distance, place: Vector, out: Vector, radius: float, cuts: list[Distance], dark: list[trimesh.Trimesh]
) -> Distance:
    """A housing that ends at a place with a lid."""
    _lid(place, out, radius, cuts, dark)
    return cut(body, [_space_beyond(place, out, radius)], 0.2 * radius)


def _range(joint: Joint) -> tuple[float, float]:
    """The drawn range of a slide [m], within +-_FARTHEST."""
    return max(joint.limits.lower, -_FARTHEST), min(joint.limits.upper, _FARTHEST)


def _space_beyond(place: Vector, out: Vector, radius: float, gap: float = 0.0) -> Distance:
    """The space beyond the end of a housing, to be cut off. It begins by ``gap`` before the end [m]."""
    return drum(place + (1.2 * radius - gap) * out, out, 1.25 * radius, 1.2 * radius, 0.0)


# ---- hands --------------------------------------------------------------------------------------------------------------------


def _hand(end: Vector, spread: Vector) -> list[trimesh.Trimesh]:
    """A palm and two half-open fingers between a flange and the point between the fingertips."""
    length, along = float(np.linalg.norm(end)), _unit(end)
    turn = np.stack([np.cross(spread, along), spread, along], axis=1)

    def part(middle: float, aside: float, half: tuple[float, float, float], fillet: float) -> Distance:
        return box(middle * end + aside * length * spread, turn, length * np.array(half), fillet * length)

    flange = drum(0.1 * end, along, 0.42 * length, 0.1 * length, 0.03 * length)
    palm = union([flange, part(0.4, 0, (0.3, 0.95, 0.25), 0.13)], 0.1 * length)
    bodies = [(palm, SHELL, 0.03), (part(0.66, 0, (0.13, 0.8, 0.03), 0.02), DARK, 0.02)]
    for side in (-1.0, 1.0):
        parts = [part(0.8, side * 0.3, (0.11, 0.12, 0.14), 0.04), part(0.98, side * 0.26, (0.09, 0.06, 0.14), 0.03)]
        bodies += [(union(parts, 0.06 * length), PAD, 0.018)]
    meshes = [(mesh_of(body, cell * length), color) for body, color, cell in bodies]
    return [paint_mesh(mesh, color) for mesh, color in meshes if mesh is not None]


def _palm(leg: _Leg) -> Distance:
    """The palm of a sliding finger."""
    length = float(np.linalg.norm(leg.foot))
    along = leg.foot / length
    turn = np.stack([np.cross(leg.axis, along), leg.axis, along], axis=1)
    return box(0.5 * leg.foot, turn, length * np.array([0.5, 0.8, 0.5]), 0.2 * length)


def _finger(joint: Joint) -> Distance:
    """A sliding finger, on the side to which it opens."""
    leg = _leg(joint)
    length, axis = float(np.linalg.norm(leg.foot)), _unit(joint.axis)
    along = joint.origin[:3, :3].T @ leg.foot / length
    turn = np.stack([np.cross(axis, along), axis, along], axis=1)
    return box(0.45 * length * along + 0.15 * length * axis, turn, length * np.array([0.18, 0.15, 0.5]), 0.1 * length)


# ---- meshes -------------------------------------------------------------------------------------------------------------------


def _unit(vector: Vector) -> Vector:
    return np.asarray(vector, dtype=np.float64) / (np.linalg.norm(vector) or 1.0)


def _turn_to(axis: Vector) -> NDArray[np.float64]:
    """A rotation, shape (3, 3), that maps z to an axis."""
    return np.asarray(align_vectors([0, 0, 1], axis))[:3, :3]


def _half_width(body: Body) -> float:
    """The mean radius of a collision shape across its longest side [m]; 0 for other shapes."""
    match body.shape:
        case Box(extents):
            return float(np.sort(extents)[:2].mean()) / 2
        case Cylinder(radius) | Capsule(radius) | Sphere(radius):
            return float(radius)
    return 0.0


def _disc(place: Vector, axis: Vector, ends: tuple[float, float], radius: float) -> trimesh.Trimesh:
    """A disc around an axis with beveled edges. ends: its coordinates along the axis, from ``place`` [m]."""
    (low, high), bevel = ends, min(0.06 * radius, (ends[1] - ends[0]) / 3)
    edge = [(radius - bevel, low), (radius, low + bevel), (radius, high - bevel), (radius - bevel, high)]
    turn = np.eye(4)
    turn[:3, :3], turn[:3, 3] = _turn_to(axis), place
    return trimesh.creation.revolve(np.array([(0.0, low), *edge, (0.0, high)]), sections=56, transform=turn)


def _box_mesh(place: Vector, turn: NDArray[np.float64], half: Vector) -> trimesh.Trimesh:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = turn, place
    return trimesh.creation.box(2 * half, T)


def paint_mesh(mesh: trimesh.Trimesh, rgba: tuple[int, ...]) -> trimesh.Trimesh:
    """Paint a mesh in place in one color (red, green, blue and opacity in 0..255), and return it."""
    mesh.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=rgba, metallicFactor=0.1, roughnessFactor=0.4))
    return mesh


def merge_parts(parts: Iterable[trimesh.Trimesh | trimesh.Scene]) -> trimesh.Scene:
    """One scene of all parts."""
    scene = trimesh.Scene()
    for part in parts:
        for geometry in [part] if isinstance(part, trimesh.Trimesh) else part.dump():
            scene.add_geometry(geometry)
    return scene
