"""``ulna run``: moves a real arm, or a dry run of it, to a goal."""

from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import RenderableType

from ulna.arms import Arm, Franka, Recorder
from ulna.cli.cell import Obstacles
from ulna.cli.depends import Json, as_options, command
from ulna.cli.options import Degrees, Seed
from ulna.cli.output import Output
from ulna.cli.plan import Clearance, found_data, search_shown
from ulna.cli.targets import Start, positions
from ulna.description.arrays import as_number
from ulna.errors import InputError
from ulna.planning.trajectory import Trajectory
from ulna.robot import load


class ArmName(StrEnum):
    """The arms that have a driver."""

    FRANKA = "franka"


Driver = Annotated[ArmName, typer.Argument(metavar="ARM", help="franka: a Franka Research 3, by pylibfranka.")]
Address = Annotated[str, typer.Option(metavar="HOST", help="The address of the arm's controller.")]
Goal = Annotated[str, typer.Option("--to", metavar="NUMBERS", help="Joint positions to reach, or home.")]
Speed = Annotated[float, typer.Option(metavar="NUMBER", help="The fraction of the arm's speed, above 0 and at most 1.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Connect to nothing and move nothing: check and record the commands.")]
Yes = Annotated[bool, typer.Option("--yes", help="Move without asking first.")]
Csv = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the commands and measured positions: one row per ms.")]
_SPEED = 0.2  # the default is slow enough to reach the emergency stop

RUN_KEYS = (
    "arm; robot; status; success; reason; joints; path: rows of q; duration at this speed, in seconds, or null; moved: whether "
    "the arm was commanded to; stopped; arrived: whether it is at the goal; ended: the end of the run, in words, or null; "
    "tracking_error, in radians, or null; lost: periods without a command; q: where it is."
)


@command
def run(
    arm: Driver,
    *,
    to: Goal,
    address: Address = "127.0.0.1",
    start: Start = None,
    world: Obstacles,
    clearance: Clearance = 0.0,
    seed: Seed = 0,
    speed: Speed = _SPEED,
    dry_run: DryRun = False,
    yes: Yes = False,
    csv: Csv = None,
    degrees: Degrees = False,
    as_json: Json = False,
) -> Output:
    """Move an arm from its measured position to a goal, free of collision, and slowly unless --speed changes that.

    Example: ulna run franka --address 127.0.0.1 --to home. It prints the motion and asks before the arm moves, unless --yes is
    given. Read docs/franka.md first, and keep the emergency stop in your hand. Exit status 0 if the arm is at the goal; 1 if no
    motion was found or the arm did not arrive.
    """
    robot = load("fr3")
    if start is not None and not dry_run:
        raise InputError("--from", "the arm starts at its measured position; --from requires --dry-run")
    if as_json and not (yes or dry_run):
        raise InputError("--json", "it asks no question; add --yes or --dry-run")
    as_number("--speed", speed, 0.0, "a number above 0 and at most 1", above=True, most=1.0)
    goal = positions("--to", to, robot, degrees=degrees)
    begin = robot.home if start is None else positions("--from", start, robot, degrees=degrees)
    driver: Arm = Recorder(begin) if dry_run else Franka(address, robot=robot)
    with as_options({"q_start": "--from", "goal": "--to"}), search_shown() as progress:
        found = robot.plan(driver.q, goal, world, clearance=clearance, seed=seed, progress=progress)
    motion, record = None, None
    if found:
        motion = found.trajectory(limits=driver.model.limits)
        place = "a dry run" if dry_run else f"the {driver.model.name} at {address}"
        if dry_run or yes or _confirmed(motion, speed, place):
            record = driver.run(motion, speed=speed)
            if csv is not None:
                record.to_csv(csv)
    data = {
        "arm": arm,
        **found_data(robot, found),
        "duration": motion and motion.duration / speed,
        "moved": record is not None,
        "stopped": record is not None and record.stopped,
        "arrived": record is not None and record.arrived,
        "ended": None if record is None else record.ended,
        "tracking_error": None if record is None else record.tracking_error,
        "lost": 0 if record is None else record.lost,
        "q": driver.q,
    }
    return Output(data, run_table, status=0 if record else 1)


def _confirmed(motion: Trajectory, speed: float, place: str) -> bool:
    """Ask the user whether the arm may move."""
    typer.echo(f"{place} will move for {motion.duration / speed:.1f} s at {speed:.0%} of its speed.", err=True)
    return typer.confirm("Is everybody clear of the arm, and may it move?", err=True)


def run_table(data) -> Iterator[RenderableType]:
    """Show a sentence about the plan, and one about the run."""
    yield data["reason"]
    if data["moved"]:
        how = f"stopped {data['ended']}" if data["stopped"] else data["ended"]
        lost = f", {data['lost']} periods without a command" if data["lost"] else ""
        yield f"{how}, tracking error {data['tracking_error']:.2g} rad{lost}"
    elif data["success"]:
        yield "nothing has moved"
    yield "q = " + ", ".join(f"{value:.6g}" for value in data["q"])
