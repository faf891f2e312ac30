"""``ulna info``: the joints, links and collision shapes of a robot."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict

from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import command
from ulna.cli.options import AnyRobot
from ulna.cli.output import Output, attributes, limit, make_table
from ulna.description.robot_description import JointType
from ulna.ik.closed_form.axes import N_AXES
from ulna.ik.closed_form.closed_form import closed_form_of
from ulna.robot.coordinates import coordinates_of
from ulna.robot.hand_link import hand_link

INFO_KEYS = (
    "name; base; tip: null if there are several; hand: the link that other commands take; leaves; n_dof; joints: one for each "
    "entry of q, with name, type, lower, upper, soft_lower, soft_upper, velocity_limit, home, unit; fixed_joints; mimic_joints: "
    "name, joint, multiplier, offset; links; groups: the joints of each, and named_configurations: the q of each, both of "
    "the SRDF; srdf: the path of the file found next to the URDF, else empty; closed_form: of the hand's "
    "inverse kinematics, null without a closed form: family, from_end, held, miss, is_exact, added: the number of joints "
    "added to make six; "
    "collision_shapes: name, link, kind, and extents, or radius and length, or uri and scale."
)


@command
def info(robot: AnyRobot) -> Output:
    """Print a robot's joints with their limits, its links and its collision shapes."""
    joints = robot.description.joints
    columns = robot.lower, robot.upper, robot.soft_lower, robot.soft_upper, robot.velocity_limits, robot.home
    keys = ("lower", "upper", "soft_lower", "soft_upper", "velocity_limit", "home")
    form = closed_form_of(robot.tree, robot.tip or hand_link(robot))
    data = {
        "name": robot.name,
        "base": robot.base,
        "tip": robot.tip,
        "hand": robot.tip or hand_link(robot),
        "leaves": list(robot.tree.leaves),
        "n_dof": robot.n_dof,
        "joints": [
            {"name": entry.name, "type": entry.type, **dict(zip(keys, row, strict=True)), "unit": entry.unit}
            for entry, row in zip(coordinates_of(robot), zip(*columns, strict=True), strict=True)
        ],
        "fixed_joints": [j.name for j in joints if j.type == JointType.FIXED],
        "mimic_joints": [{"name": j.name, **asdict(j.mimic)} for j in joints if j.mimic is not None],
        "links": list(robot.link_names),
        "groups": {name: list(group.joint_names) for name, group in robot.groups.items()},
        "named_configurations": dict(robot.named_configurations),
        "srdf": robot.srdf.found_at,
        "closed_form": form
        and attributes(form, "family", "from_end", "held", "miss", "is_exact") | {"added": N_AXES - form.n_joints},
        "collision_shapes": [
            {"name": body.name, "link": link.name, "kind": type(body.shape).__name__.lower(), **asdict(body.shape)}
            for link in robot.description.links
            for body in link.collisions
        ],
    }
    return Output(data, info_table)


def info_table(data) -> Iterator[RenderableType]:
    """Show the robot's name, joints, links and collision shapes."""
    tip = data["tip"] or f"{len(data['leaves'])} tips, the hand is {data['hand']}"
    yield Text.assemble((data["name"], "bold"), f": {data['n_dof']} dof, {data['base']} to {tip}")
    table = make_table(["joint", "type"], ["lower", "upper", "home", "unit", "velocity\nlimit", "unit"], [])
    for joint in data["joints"]:
        lower, upper, home, velocity = (limit(joint[key]) for key in ("lower", "upper", "home", "velocity_limit"))
        table.add_row(joint["name"], joint["type"], lower, upper, home, joint["unit"], velocity, f"{joint['unit']}/s")
    yield table
    for joint in data["joints"]:
        if (joint["soft_lower"], joint["soft_upper"]) != (joint["lower"], joint["upper"]):
            yield f"{joint['name']}: soft limits {limit(joint['soft_lower'])} to {limit(joint['soft_upper'])} {joint['unit']}"
    for mimic in data["mimic_joints"]:
        yield f"{mimic['name']} = {mimic['multiplier']:g} * {mimic['joint']} + {mimic['offset']:g}"
    yield closed_form_text(data["closed_form"])
    yield _names("fixed joints", data["fixed_joints"])
    yield _names("links", data["links"])
    for name, joints in data["groups"].items():
        yield _names(f"group {name}", joints)
    if data["named_configurations"]:
        yield _names("named configurations", list(data["named_configurations"]))
    if data["srdf"]:
        yield Text.assemble(("SRDF", "bold"), f": {data['srdf']}, found next to the URDF; --no-srdf ignores it")
    shapes = make_table(["collision shape", "link", "kind"], [], ["extents [m]"])
    for shape in data["collision_shapes"]:
        shapes.add_row(shape["name"], shape["link"], shape["kind"], _measures(shape))
    yield shapes if data["collision_shapes"] else "no collision shapes: ulna check has nothing to check"


def closed_form_text(form) -> Text:
    """Describe the closed form in a line."""
    if form is None:
        return Text.assemble(("inverse kinematics", "bold"), ": no closed form")
    held, seen = f", {form['held']} held" if form["held"] else "", ", from the end" if form["from_end"] else ""
    seen += f", with {form['added']} of the joints added" if form["added"] else ""
    tier = "exact" if form["is_exact"] else "approximate, for starts of the search only"
    text = f": closed form{held}: {form['family']}{seen} ({tier}; the axes deviate by {form['miss']:.1g})"
    return Text.assemble(("inverse kinematics", "bold"), text)


def _names(kind: str, names: Sequence[str]) -> Text:
    return Text.assemble((f"{kind} ({len(names)})", "bold"), ": " * bool(names), ", ".join(names))


def _measures(shape) -> str:
    if "extents" in shape:
        return " x ".join(f"{extent:g}" for extent in shape["extents"])
    rest = {key: value for key, value in shape.items() if key not in ("name", "link", "kind")}
    if shape["kind"] == "mesh":
        return f"{rest['uri']}, scale {' '.join(f'{s:g}' for s in rest['scale'])}"
    return ", ".join(f"{key} {value:g}" for key, value in rest.items())
