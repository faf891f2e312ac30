"""``ulna info`` for people."""

from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.text import Text

from ulna.tables.writing import make_table, short


def info_view(data) -> Iterator[RenderableType]:
    """The robot's names, its joints, its links and its collision shapes."""
    tip = data["tip"] or f"{len(data['leaves'])} tips"
    yield Text.assemble((data["name"], "bold"), f": {data['n_dof']} dof, {data['base']} to {tip}")
    table = make_table(["joint", "type"], ["lower", "upper", "home", "unit", "velocity\nlimit", "unit"], [])
    for joint in data["joints"]:
        lower, upper, home, velocity = (short(joint[key]) for key in ("lower", "upper", "home", "velocity_limit"))
        table.add_row(joint["name"], joint["type"], lower, upper, home, joint["unit"], velocity, f"{joint['unit']}/s")
    yield table
    for joint in data["joints"]:
        if (joint["soft_lower"], joint["soft_upper"]) != (joint["lower"], joint["upper"]):
            yield f"{joint['name']}: soft limits {short(joint['soft_lower'])} to {short(joint['soft_upper'])} {joint['unit']}"
    for mimic in data["mimic_joints"]:
        yield f"{mimic['name']} = {mimic['multiplier']:g} * {mimic['joint']} + {mimic['offset']:g}"
    yield _names("fixed joints", data["fixed_joints"])
    yield _names("links", data["links"])
    shapes = make_table(["collision shape", "link", "kind"], [], ["extents [m]"])
    for shape in data["collision_shapes"]:
        shapes.add_row(shape["name"], shape["link"], shape["kind"], _measures(shape))
    yield shapes if data["collision_shapes"] else "no collision shapes: ulna check has nothing to check"


def _names(kind: str, names: Sequence[str]) -> Text:
    return Text.assemble((f"{kind} ({len(names)})", "bold"), ": " * bool(names), ", ".join(names))


def _measures(shape) -> str:
    if "extents" in shape:
        return " x ".join(f"{extent:g}" for extent in shape["extents"])
    rest = {key: value for key, value in shape.items() if key not in ("name", "link", "kind")}
    if shape["kind"] == "mesh":
        return f"{rest['uri']}, scale {' '.join(f'{s:g}' for s in rest['scale'])}"
    return ", ".join(f"{key} {value:g}" for key, value in rest.items())
