"""``ulna torque``: a robot's joint torques, their limits, and the payload that the motors can hold."""

from collections.abc import Iterator
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import as_options, command
from ulna.cli.loads import Effort, PayloadText, effort_limits, holding, payload_of
from ulna.cli.mount import FreeFall, mounted
from ulna.cli.options import AnyRobot, Degrees, Link
from ulna.cli.output import Q_KEYS, Output, data_of_q, make_table, number, title
from ulna.cli.targets import Q, numbers
from ulna.description.names.by_name import rated_payload
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate, coordinates_of

Array = NDArray[np.float64]
Velocities = Annotated[str | None, typer.Option("--qd", metavar="NUMBERS", help="Joint velocities; 0 by default.")]
Accelerations = Annotated[str | None, typer.Option("--qdd", metavar="NUMBERS", help="Joint accelerations; 0 by default.")]

TORQUE_KEYS = (
    f"{Q_KEYS}; link; gravity; mass and center: of the payload, in the frame of the link; joints; units: Nm or N; torque; "
    "limit: null where none is known; share: torque by limit; bears: the largest mass that each joint can hold there, kg, "
    "null without a limit; payload: of all joints; limited_by: the joint that limits it, or null; "
    "unknown: joints without a limit; holds: whether all limits are known and kept; rated: the rated payload, kg, or null."
)


@command
def torque(
    robot: AnyRobot,
    link: Link,
    q: Q,
    free_fall: FreeFall,
    *,
    payload: PayloadText = None,
    qd: Velocities = None,
    qdd: Accelerations = None,
    effort: Effort = None,
    degrees: Degrees = False,
) -> Output:
    """Check whether the arm can hold a part: the torque and limit of each joint, and the maximum mass.

    Example: ulna torque panda --payload 3kg@0,0,0.1, or ulna torque ur10e --mount ceiling. Exit status 0 if all torques are
    within known limits, 1 if not.
    """
    robot = mounted(robot, free_fall)
    mass, center = payload_of(payload)
    rates = [_rates(option, text, robot, degrees=degrees) for option, text in (("--qd", qd), ("--qdd", qdd))]
    unknown, most = effort_limits(robot, effort)
    held = holding(robot, mass, center, link)
    with as_options({"com": "--payload"}):
        torques = held.inverse_dynamics(q, *(np.zeros(robot.n_dof) if rate is None else rate for rate in rates))
        bears = robot.payload(q, *rates, com=center, link=link, torque=most, by_joint=True)
    holds = not unknown and bool((np.abs(torques) <= most).all())
    entries = coordinates_of(robot)
    limited = bool(len(bears)) and bool(np.isfinite(bears.min()))
    data = {
        **data_of_q(robot, q),
        "link": link,
        "gravity": robot.gravity,
        "mass": mass,
        "center": center,
        "joints": [entry.name for entry in entries],
        "units": [entry.effort_unit for entry in entries],
        "torque": torques,
        "limit": most,
        "share": [abs(value) / limit if np.isfinite(limit) else None for value, limit in zip(torques, most, strict=True)],
        "bears": bears,
        "payload": float(bears.min(initial=np.inf)),
        "limited_by": entries[int(np.argmin(bears))].name if limited else None,
        "unknown": unknown,
        "holds": holds,
        "rated": rated_payload(robot.name),
    }
    return Output(data, torque_table, status=0 if holds else 1)


def _rates(option: str, text: str | None, robot: Robot, *, degrees: bool) -> Array | None:
    if text is None:
        return None
    entries = [Coordinate(each.name, each.unit if degrees else "", each.type) for each in coordinates_of(robot)]
    return np.array(numbers(option, text, entries, degrees=degrees))


def torque_table(data) -> Iterator[RenderableType]:
    """Show a row for each joint, and a sentence about the arm."""
    place = f"{', '.join(f'{x:g}' for x in data['center'])} of {data['link']}"
    what = f"{data['mass']:g} kg at {place}" if data["mass"] else "no payload"
    yield title(data, f"torques with {what}")
    table = make_table(["joint"], ["torque", "limit", "share", "can hold [kg]"], [""])
    for joint, unit, torque, most, share, mass in zip(
        *(data[key] for key in ("joints", "units", "torque", "limit", "share", "bears")), strict=True
    ):
        look = "" if share is None or share <= 1.0 else "bold red"
        cells = number(torque, 2), "none" if most is None else number(most, 2), "" if share is None else f"{100 * share:.1f} %"
        bears = "any" if mass is None else number(mass, 2)
        table.add_row(joint, *(Text(cell, look) for cell in cells), bears, unit)
    yield table
    if data["limited_by"] is None:
        yield f"at {place} no joint limits the payload"
    else:
        yield f"at {place} it can hold {data['payload']:.2f} kg, limited by {data['limited_by']}"
    if data["rated"] is not None:
        if data["mass"] > data["rated"]:
            yield Text(f"more than the maker's rated payload of {data['rated']:g} kg", "bold yellow")
        else:
            yield f"the maker's rated payload is {data['rated']:g} kg"
    if data["holds"]:
        yield Text("within the torque limits", "bold green")
    elif any(share is not None and share > 1.0 for share in data["share"]):
        yield Text("beyond the torque limits", "bold red")
    else:
        yield Text(
            f"unknown: no effort limit above 0 for {', '.join(data['unknown'])}; --effort sets it",
            "bold yellow",
        )
