"""Lists the types of every kernel's arguments in a CUDA thread, where a number is a float64.

One table maps an argument's name to its type: everywhere, in a folder, in a module, or in one kernel. The narrowest entry
applies. Where a thread tests the eight children of a BVH node, it uses an ``f64x8``, as the CPU does. The compiler splits it into
eight numbers.
"""

import inspect

from numba import from_dtype, types

from ulna.engine import signatures
from ulna.engine.compiler import numba_types
from ulna.kernels.chain.branch_records import Accuracy, Branches
from ulna.kernels.collision.scene import Carried, Intervals, Mover, Near, Nearness, Planes, Posed, Reach, Scene
from ulna.kernels.distance.body_records import Body, Core, Simplex
from ulna.kernels.dynamics.dynamics_records import BodyRows, FallRows, ForceRows, Mechanism, RateRows, State
from ulna.kernels.ik.search_records import SearchSettings
from ulna.kernels.servo.objective import Objective, Program, Steady
from ulna.kernels.servo.servo_records import HandGoal, JointLimits, JointState, ServoGoal, ServoSettings, StopCounters

INDEX_ROWS, INDICES, MATRIX, NUMBER, NUMBERS, PAIRS, TABLE, TRUTH_TABLE, WHOLE = numba_types((
    signatures.INDEX_ROWS, signatures.INDICES, signatures.MATRIX, signatures.NUMBER, signatures.NUMBERS, signatures.PAIRS,
    signatures.TABLE, signatures.TRUTH_TABLE, signatures.WHOLE,
))  # fmt: skip
TRUTH = types.boolean
SETTINGS = from_dtype(SearchSettings.structure)  # of a search of inverse kinematics
ANGLE, VECTOR, SIZE, TWIST, POSE = (types.UniTuple(NUMBER, n) for n in (2, 3, 4, 6, 12))  # an angle: its sine and cosine
PAIR = types.UniTuple(ANGLE, 2)  # two angles: their middle, and the way from it to one of them
TWO_VECTORS, THREE_VECTORS = (types.UniTuple(VECTOR, n) for n in (2, 3))
CORE = types.NamedTuple((WHOLE, VECTOR, TABLE), Core)
BODY = types.NamedTuple((POSE, CORE, NUMBER), Body)
POSED = types.NamedTuple((TABLE, TABLE, WHOLE, POSE), Posed)
POSED_BOX = types.NamedTuple((TABLE, types.none, WHOLE, POSE), Posed)
RELATIVE = types.Tuple((THREE_VECTORS, VECTOR))  # a rotation by rows, and a translation
CORES = types.Tuple((CORE, CORE, RELATIVE))  # those of EPA
DISTANCE = types.Tuple((NUMBER, VECTOR, VECTOR, VECTOR))  # and witness points and normal
CORNER = types.Tuple((NUMBER, VECTOR))  # the square of a distance, and a point
POINTS = types.Tuple((NUMBER, VECTOR, VECTOR))  # and two points
SIMPLEX = types.NamedTuple((VECTOR, THREE_VECTORS, THREE_VECTORS, VECTOR), Simplex)  # of GJK
CANDIDATE = types.UniTuple(NUMBER, 3)  # of GJK: |v|^2 and two weights
SCENE = types.NamedTuple((TABLE, TABLE, TABLE, PAIRS, TABLE, TABLE, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene)
SCENE_OF_BOXES = types.NamedTuple(
    (TABLE, TABLE, types.none, PAIRS, TABLE, types.none, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene
)
INTERVALS = types.NamedTuple((NUMBER, TRUTH, TRUTH, NUMBER, types.none, NUMBER), Intervals)
CARRIED = types.NamedTuple((
    MATRIX, INDICES, INDICES, INDEX_ROWS, INDEX_ROWS, INDICES, MATRIX, MATRIX, MATRIX, NUMBERS, NUMBERS, NUMBERS,
    NUMBERS, NUMBERS, INDICES, INDICES,
), Carried)  # fmt: skip
BRANCHES = types.NamedTuple((NUMBERS, WHOLE, NUMBERS, NUMBERS, NUMBERS), Branches)
POLYTOPE = types.UniTuple(MATRIX, 3)  # points, faces and edges of EPA
PLANES = types.NamedTuple((MATRIX, INDICES), Planes)
NEAR = types.NamedTuple((NUMBERS, NUMBERS, MATRIX, INDEX_ROWS, INDICES, INDICES, NUMBERS, NUMBERS, PLANES, POLYTOPE), Near)

OBJECTIVE = types.NamedTuple((*(NUMBERS,) * 8, INDICES), Objective)
PROGRAM = types.NamedTuple((NUMBERS, NUMBERS, NUMBERS, INDICES, NUMBERS, NUMBERS), Program)
STEADY = types.NamedTuple((*(NUMBERS,) * 11, INDICES, NUMBERS), Steady)
HANDS, STATE = numba_types((signatures.Array(HandGoal, 1), signatures.Array(JointState, 1)))
(LIMITS,) = numba_types((signatures.Array(JointLimits, 1, constant=True),))
GOAL = types.NamedTuple((WHOLE, NUMBERS, NUMBERS, HANDS), ServoGoal)
MECHANISM = types.NamedTuple((TABLE, TABLE), Mechanism)
FORCE_ROWS, FALL_ROWS, BODY_ROWS, RATE_ROWS = (
    types.NamedTuple((NUMBERS,) * len(each._fields), each) for each in (ForceRows, FallRows, BodyRows, RateRows)
)
INERTIA = types.Tuple((NUMBER, VECTOR, TWIST))  # mass, moment and tensor


def _each(names: str, numba_type) -> dict:
    return dict.fromkeys(names.split(), numba_type)


TYPES = {
    "": {
        **_each("x y z p2 r2 theta limit distance damping rate share like reach size rounding way noise object_rounding", NUMBER),
        **_each("radius_a radius_b half_a half_b height wanted hits", NUMBER),
        **_each("i j k n_dof row lane number kind kind_a kind_b n_faces n_edges across down expressed_in", WHOLE),
        **_each("root", WHOLE),
        **_each("v w p q c d h g n t u", VECTOR),
        **_each("a b pose target end", POSE),
        **_each("e whole rest residual", TWIST),
        **_each("mask active by_values", TRUTH),
        **_each("r", THREE_VECTORS),
        **_each("chain table joints frames limits bodies others objects vertices vertices_a vertices_b", TABLE),
        **_each("matrix nodes faces edges", MATRIX),
        **_each("posture settings velocity_limits", NUMBERS),
    },
    "spatial": {"rows": NUMBERS, **_each("defect fault", NUMBER)},
    "spatial.se3.turned_about_z": {**_each("s c", NUMBER)},
    "spatial.vectors": {**_each("a b", VECTOR)},
    **{
        f"spatial.vectors.{name}": {"a": POSE}
        for name in ("x_axis", "y_axis", "z_axis", "origin", "rotate", "rotate_inverse", "transform", "transform_inverse")
    },
    "spatial.elementary": {**_each("s c", NUMBER)},
    "spatial.se3.lane_pose": {"rows": MATRIX},
    "chain": {
        **_each("first second third fourth fifth sixth bend angle angle_a angle_b bends free", ANGLE), "n": WHOLE,
        "motion": POSE, **_each("two three reach v", VECTOR), "both": PAIR,
        **_each("r whole last columns", THREE_VECTORS), "angles": VECTOR,
        **_each("a_s a_c discriminant sign square residual_square determination", NUMBER),
        **_each("separation next_separation min_separation conditioning conditioning_5", NUMBER),
        **_each("row branch", WHOLE), "is_first": INDICES, "branches": BRANCHES,
        "known": types.NamedTuple((NUMBER,) * 4, Accuracy),
        "limits": ANGLE,
    },
    "chain.subproblems": {"k": VECTOR, **_each("b d s c", NUMBER)},
    "chain.closed_form_rows": {"normals": WHOLE},
    **{f"chain.{name}": {**_each("x y z", VECTOR)} for name in ("closed_form_rows.by_columns", "parallel_links.row_of")},
    "chain.spherical_wrist": {"family": WHOLE, **_each("outer inner", ANGLE)},
    "chain.three_parallel.within_reach": {"singular": TRUTH, "angles": types.UniTuple(ANGLE, 3)},
    "chain.parallel_links.links": {"angles": SIZE, "both": TWO_VECTORS},
    "chain.closed_form_rows.store_angle": {"angle": NUMBER},
    "chain.sliding_arm": {"family": WHOLE, **_each("first second third joint", VECTOR), **_each("way sign_1 sign_2", NUMBER)},
    "chain.sliding_arm.lengths_in_plane": {"k": VECTOR},
    "chain.quartic_arm": {**_each("left_1 left_2", VECTOR)},
    "chain.quartic_arm.parts": {"k": VECTOR},
    "chain.quartic_arm.square_of_size": {**_each("u v", ANGLE)},
    "chain.quartic_arm.first_of_circles": {**_each("u b_1 b_2", ANGLE), "inverse": NUMBER},
    "chain.quartic_arm.one_of_pencil": {
        "both": types.Tuple((ANGLE, SIZE, SIZE, NUMBER)), "passing_lines": types.UniTuple(TRUTH, 2), "line": NUMBER,
    },
    "chain.quartic_arm.circles": {**_each("first second", VECTOR)},
    "chain.two_circles": {
        **_each("u b_1 b_2 axes", ANGLE), **_each("form lines", SIZE), **_each("line k a b d size off", NUMBER),
    },
    "distance": {
        "scratch": POLYTOPE, "cores": CORES, **_each("core core_a core_b", CORE), "relative": RELATIVE,
        **_each("index square gap depth angle level", NUMBER), "points": MATRIX,
    },
    "distance.box_distance": {"best": POINTS, "other": POINTS, "length": NUMBER},
    "distance.box_distance.edge_pair": {"sides": TWO_VECTORS, "s": SIZE},
    "distance.box_distance.nearest_corner": {"edges": THREE_VECTORS},
    "distance.box_distance.nearest_edges": {"sides": TWO_VECTORS, "s": THREE_VECTORS},
    "distance.box_distance.nearest_of_four": {**_each("y z", VECTOR)},
    "distance.box_distance.nearer_corner": {"best": CORNER, "other": CORNER},
    "distance.box_distance.pose_axis": {"k": NUMBER},
    "distance.box_distance.row_signs": {"row": VECTOR},
    "distance.box_sat": {"m": THREE_VECTORS, **_each("widest axis", NUMBER)},
    "distance.box_sat.edge_gaps": {**_each("t h", ANGLE), "r": TWO_VECTORS},
    "distance.box_sat.widest_of_edges": {"edges": TWO_VECTORS},
    "distance.epa": {"common_point": VECTOR, "z": VECTOR},
    "distance.epa.points_needed": {**_each("n m", WHOLE)},
    "distance.epa.with_penetration": {"contact": DISTANCE, "inside": NUMBER},
    "distance.epa_polytope.set_face": {"f": WHOLE},
    "distance.epa_polytope.toggle_edge": {**_each("i j", NUMBER)},
    "distance.epa_polytope.remove_visible": {"w": WHOLE},
    "distance.epa_polytope.unit_cross": {**_each("a b", VECTOR)},
    "distance.gjk": {"simplex": SIMPLEX, **_each("edges normals", THREE_VECTORS), **_each("e f", VECTOR)},
    "distance.gjk.point_of": {**_each("k1 k2", VECTOR)},
    "distance.gjk.chosen_three": {**_each("a b", THREE_VECTORS)},
    "distance.gjk.nearer_candidate": {"best": CANDIDATE, "other": CANDIDATE},
    **{f"distance.pairs.pair_{name}": {"a": BODY, "b": BODY} for name in ("distance", "overlap", "gap")},
    "distance.pairs.contact_reach": {"a": BODY, "b": BODY},
    "distance.pairs.outer_half": {"body": BODY},
    "distance.swept_segments": {"core": DISTANCE, "otherwise": VECTOR, "outwards": VECTOR},
    "collision": {
        **_each("bounds", TWO_VECTORS), **_each("stack found", INDICES), **_each("speeds rows", MATRIX), "pairs": PAIRS,
        "points": TABLE, **_each("posed ours theirs", POSED), "scene": SCENE, "heights": NUMBERS, "scratch": POLYTOPE,
        "best": VECTOR,
        **_each("within half clear margin speed bend turning slack slope fastest extent", NUMBER), **_each("n p node top", WHOLE),
        **_each("is_instant stop_at_contact", TRUTH),
        "carried": CARRIED, "margins": types.none, "from_end": WHOLE, "intervals": INTERVALS, "group": types.UniTuple(WHOLE, 3),
    },
    "collision.bvh.gap_bound": {"gap": VECTOR},
    "collision.bvh": {**_each("x half", VECTOR), **_each("end axis", WHOLE), "height": NUMBER},
    "collision.bounding_planes": {**_each("x half normal", VECTOR), "planes": PLANES, "contacts": MATRIX},
    "collision.contacts": {
        "planes": PLANES, "number": WHOLE,
        **_each("contacts contact_rows from_rows to_rows out", MATRIX), **_each("joint witness first count w", WHOLE),
        **_each("contact gradient", NUMBERS), "solid": types.Tuple((WHOLE, WHOLE, NUMBER)), "row_range": types.UniTuple(WHOLE, 2),
        "order": INDICES,
        **_each("sign clearance", NUMBER), "near": NEAR, "excess": NUMBERS,
        "nearness": types.NamedTuple((NUMBER, types.none, NUMBER), Nearness),
    },
    "collision.ball_motion": {
        **_each("q_a q_b spread rows", NUMBERS), **_each("joint shared a b g", WHOLE), **_each("p w_shared", VECTOR),
        **_each("steps speeds bends", MATRIX), "length": NUMBER,
    },
    "collision.reached.has_exact_ball": {**_each("kind other", WHOLE)},
    "collision.reached.core_slope": {"e": VECTOR},
    "collision.overlap.overlaps_any": {"n_found": WHOLE},
    "collision.reached.push_reached": {"body": types.Tuple((POSED, VECTOR, TWO_VECTORS))},
    "collision.posed_pair.solid_at": {"w": WHOLE},
    "collision.reached": {**_each("center half p", VECTOR), **_each("radius", NUMBER), "axis": WHOLE, "margins": types.none},
    "collision.interval": {**_each("o g", WHOLE), "p": VECTOR, "motion": NUMBER},
    "collision.interval.body_outcome": {
        "mover": types.Tuple((WHOLE, WHOLE, NUMBER)), "candidates": types.Tuple((WHOLE, TRUTH, INDICES)),
    },
    "collision.interval.object_outcome": {
        "mover": types.NamedTuple((WHOLE, WHOLE, POSE, VECTOR, VECTOR), Mover), "reach": types.NamedTuple((NUMBER,) * 4, Reach),
    },
    "collision.interval.pair_outcome": {"pair": types.UniTuple(WHOLE, 3), "reach": types.UniTuple(NUMBER, 2)},
    "collision.interval.spheres_approach": {"pair": types.UniTuple(WHOLE, 3), "centers": TWO_VECTORS},
    # Here one configuration is a column, chosen by its lane, of rows of several.
    "collision.nearest.splat_result": {"best_rows": MATRIX},
    "collision.nearest.nearest_indexed": {**_each("body_rows bound_rows", MATRIX), "search": types.Tuple((INDICES, NUMBERS))},
    "collision.nearest.nearest_of_body": {"search": types.Tuple((INDICES, NUMBERS))},
    "collision.overlap.overlaps_indexed": {**_each("body_rows bound_rows", MATRIX)},
    "dynamics": {
        "mechanism": MECHANISM, "state": types.NamedTuple((NUMBERS,) * 3, State), "gravity": VECTOR, "inertia": INERTIA,
        **_each("linear angular dw l", VECTOR), **_each("s c", TWIST), **_each("columns rows", NUMBERS),
        "work": types.Tuple((BODY_ROWS, RATE_ROWS)), "derivative_rows": types.UniTuple(NUMBERS, 2), "motion": TWO_VECTORS,
        **_each("n r", WHOLE),
    },
    "dynamics.rigid_body": {**_each("a b f", TWO_VECTORS)},
    "dynamics.rigid_body.add_inertias": {**_each("a b", INERTIA)}, "dynamics.rigid_body.rotate_tensor": {"a": POSE},
    **{f"dynamics.newton_euler.{name}": {"rows": FORCE_ROWS} for name in ("newton_euler", "base_motion", "move", "carry")},
    "dynamics.newton_euler.store_motion": {"a": VECTOR},
    **{f"dynamics.composite.{name}": {"rows": BODY_ROWS} for name in ("pose_bodies", "mass_matrix", "moment_columns")},
    "dynamics.gravity": {"rows": FALL_ROWS, "held": types.Tuple((NUMBER, VECTOR))},
    "dynamics.derivatives.coriolis_of": {"v": TWO_VECTORS},
    "ik": {
        "rows": NUMBERS, "settings": SETTINGS, **_each("p r", WHOLE), **_each("slack dt cosine sine running", NUMBER),
        **_each("settled is_pointing", TRUTH),
    },
    "ik.task_error.task_error": {"slack": NUMBERS},
    "ik.bounded_least_squares": {"v": TWIST, "scratch": types.UniTuple(NUMBERS, 5)},
    "ik.bounded_least_squares.negated_where": {**_each("a b", TWIST)},
    "ik.bounded_least_squares.release_steepest": {"rows": types.UniTuple(NUMBERS, 3)},
    "ik.damped_system": {"v": TWIST}, "ik.singular_values.add_rotated": {"v": TWIST},
    "ik.nearest_branch": {**_each("q seed most inverse_reach", NUMBER), **_each("branch k steps", WHOLE)},
    "ik.nearest_branch.polish": {"rows": types.UniTuple(NUMBERS, 4), "scratch": types.UniTuple(NUMBERS, 3)},
    "ik.levenberg_marquardt": {"rows": types.UniTuple(NUMBERS, 5), "scratch": types.UniTuple(NUMBERS, 2)},
    "servo": {
        "limits": LIMITS, **_each("state after", STATE), "settings": from_dtype(ServoSettings.structure),
        "counters": from_dtype(StopCounters.structure), "goal": GOAL, "hands": HANDS, "active_rows": INDICES, "rows": NUMBERS,
        **_each("n m ticks worst hand", WHOLE), **_each("period below across reserve least growth by", NUMBER),
        **_each("excess columns", NUMBERS), **_each("v w change", TWIST), "chains": TABLE,
        "objective": OBJECTIVE, "program": PROGRAM, "steady": STEADY,
    },
    "servo.pace.progress_share": {"root": NUMBER}, "servo.pace.pace_of": {"is_free": TRUTH},
    "servo.pace.share_joint": {**_each("a b", WHOLE)}, "servo.pace.add_return_pull": {"pull": NUMBER},
    "servo.desired_motion": {"arrays": OBJECTIVE}, "servo.desired_motion.desired_twist": {"hand": from_dtype(HandGoal.structure)},
    "servo.braking": {**_each("x t before", NUMBER), "widened": TRUTH},
    "servo.ramped_stop": {**_each("x t before base slope low high least greatest", NUMBER)},
    "servo.desired_motion.approach": {"e": NUMBER},
}  # fmt: skip


def place_of(kernel) -> str:
    """Folder, module and name of a kernel."""
    return f"{kernel.__module__.removeprefix('ulna.kernels.')}.{kernel.__name__}"


def argument_types(kernel, **instead) -> tuple:
    """The types of a kernel's arguments, some by name instead. A ``LookupError`` says which argument the table lacks."""
    return tuple(
        instead[parameter] if parameter in instead else _type_of(place_of(kernel), parameter)
        for parameter in inspect.signature(kernel).parameters
    )


def _type_of(place: str, parameter: str):
    folder, module, _ = place.split(".")
    for scope in (place, f"{folder}.{module}", folder, ""):
        if parameter in TYPES.get(scope, {}):
            return TYPES[scope][parameter]
    if parameter.endswith("_rows"):
        return NUMBERS
    raise LookupError(f"{place}: the table of argument types lacks {parameter!r}")
