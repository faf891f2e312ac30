"""``ulna reach``: computes, plots and shows maps of the poses that a robot reaches."""

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import RenderableType
from rich.progress import BarColumn, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text
from typer.core import TyperGroup

from ulna.cli.cell import Meshes, Obstacles, checked_robot
from ulna.cli.depends import Json, command, defaults_of
from ulna.cli.options import LinkName, Loading, OnPage, RobotName, Seed, TaskName, load_robot, named_or_hand
from ulna.cli.output import Data, Output, make_table, printable, warn, write_figure
from ulna.cli.targets import XYZ, numbers
from ulna.collision.world import World
from ulna.engine.progress import progress_bar
from ulna.engine.threads import threads as set_threads
from ulna.errors import ClusterError, count_of, needs_extra
from ulna.reachability.map import ReachabilityMap
from ulna.reachability.reachability_map import reachability_map

MapPath = Annotated[Path, typer.Argument(metavar="MAP", help="The folder of the map, such as map.zarr.")]
Voxel = Annotated[float, typer.Option(metavar="METERS", help="The edge of a voxel.")]
Orientations = Annotated[int, typer.Option(metavar="N", help="Number of orientations per voxel.")]
Bounds = Annotated[
    str | None,
    typer.Option(metavar="NUMBERS", help='Lowest and highest corner, "x,y,z, x,y,z" in meters; by default everything in reach.'),
]
Itself = Annotated[
    bool, typer.Option("--self", help="Poses in which the robot touches itself do not count; --scene and --box check that too.")
]
KeepClearance = Annotated[bool, typer.Option("--keep-clearance", help="Store the distance to the nearest obstacle.")]
Solutions = Annotated[bool, typer.Option("--solutions", help="Store the joint positions.")]
KeepPayload = Annotated[bool, typer.Option("--keep-payload", help="Store the maximum mass that the motors hold at the link.")]
Resume = Annotated[bool, typer.Option("--resume", help="Continue an existing map, or begin one.")]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS", help="The address of a Dask cluster, as tcp://host:8786; by default threads of this process."
    ),
]
Threads = Annotated[
    int | None, typer.Option(metavar="N", help="Threads without a cluster; by default ULNA_THREADS, or one per processor.")
]
Steps = Annotated[int, typer.Option(metavar="N", help="Steps of the search for one pose; from 16000 on with reasons of failure.")]
RobotOfMap = Annotated[
    str | None,
    typer.Option("--robot", metavar="ROBOT", help="The robot, for its appearance: a map contains its collision shapes only."),
]
Figure = Annotated[Path, typer.Argument(metavar="OUT", help="The figure: .png, .svg or .pdf.")]

REACH_KEYS = (
    "path; robot; link; poses; computed; reached; share: reached of computed; statuses: how many poses have each; "
    "seconds and poses_a_second of this run, null where nothing was left to do."
)
_DEFAULTS = defaults_of(reachability_map)
_ORIENTATIONS = 32
_CONNECT_S = 10.0


class _MapUnlessNamed(TyperGroup):
    """Group in which ``ulna reach ROBOT MAP`` means ``ulna reach map ROBOT MAP``."""

    def parse_args(self, ctx, args):
        """Insert the name of the computing command, unless another command is named."""
        named = args and (args[0] in self.commands or args[0] in {"--help", "-h"})
        return super().parse_args(ctx, args if named or not args else ["map", *args])


GROUP = typer.Typer(cls=_MapUnlessNamed, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


@GROUP.callback()
def reach() -> None:
    """Map the poses that a robot reaches, computed on every core or on a Dask cluster.

    Example: ulna reach panda map.zarr --voxel 0.1 --orientations 32, then: ulna reach show map.zarr.
    """


@GROUP.command("map", epilog=f"JSON: {REACH_KEYS}")
@command
def compute(
    loading: Loading,
    *,
    robot: RobotName,
    path: MapPath,
    voxel: Voxel,
    orientations: Orientations = _ORIENTATIONS,
    bounds: Bounds = None,
    world: Obstacles,
    itself: Itself = False,
    link: LinkName = None,
    task: TaskName = _DEFAULTS["task"],
    keep_clearance: KeepClearance = False,
    solutions: Solutions = False,
    keep_payload: KeepPayload = False,
    resume: Resume = False,
    scheduler: Scheduler = None,
    threads: Threads = None,
    seed: Seed = _DEFAULTS["seed"],
    max_iterations: Steps = _DEFAULTS["max_iterations"],
    meshes: Meshes = None,
    as_json: Json = False,
) -> Output:
    """Compute a map: inverse kinematics in every voxel, in every orientation. "map" may be left out.

    Example: ulna reach panda map.zarr --voxel 0.05 --orientations 64 --scene scene.json --resume. Ctrl-C leaves a map that
    --resume continues.
    """
    arm = load_robot(loading, robot=robot)
    tip = named_or_hand(arm, link=link, as_json=as_json)
    if itself and world is None:
        world = World()
    if world is not None or keep_clearance:
        arm = checked_robot(arm, meshes=meshes, as_json=as_json)
    corners = None if bounds is None else np.reshape(numbers("--bounds", bounds, XYZ + XYZ), (2, 3))
    start, begun = time.perf_counter(), [0, 0]
    columns = TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.1f} %"), _Rate(), TimeRemainingColumn()
    with set_threads(threads), client_of(scheduler) as client, progress_bar(*columns) as bar:
        task_of_bar = bar.add_task(path.name, total=None)

        def note(done: int, total: int) -> None:
            begun[:] = [begun[0] if begun[1] else done, total]
            bar.update(task_of_bar, completed=done, total=total)

        try:
            found = reachability_map(
                arm, path, voxel=voxel, orientations=orientations, bounds=corners, world=world, link=tip, task=task,
                keep_clearance=keep_clearance, keep_solutions=solutions, keep_payload=keep_payload, client=client, resume=resume,
                seed=seed, max_iterations=max_iterations, progress=note,
            )  # fmt: skip
        except KeyboardInterrupt:
            kept = ReachabilityMap.open(path).summary.computed
            warn(f"stopped: {path} contains {kept} of {count_of(begun[1], 'pose')}; --resume continues")
            raise typer.Exit(130) from None
    return Output(map_data(found, time.perf_counter() - start, begun[1] - begun[0]), map_table)


class _Rate(ProgressColumn):
    """Column of a progress bar: poses computed per second."""

    def render(self, task: Task) -> Text:
        """Format the rate."""
        return Text(f"{task.speed:,.0f} poses/s" if task.speed else "")


@contextmanager
def client_of(address: str | None) -> Iterator[Any]:
    """Connect to the cluster at an address; yields None without one."""
    if address is None:
        yield None
        return
    with needs_extra("a Dask cluster", "reach", "dask", "distributed"):
        from distributed import Client  # noqa: PLC0415 -- needs the extra
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise ClusterError(f"no scheduler can be reached at {address} ({error})") from None
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=1.0)


@GROUP.command("plot", epilog=f"JSON: figure; {REACH_KEYS}")
@command
def plot(path: MapPath, out: Figure) -> Output:
    """Write the figure of a map: three slices, the share of reached poses by height, and reasons of failure.

    Example: ulna reach plot map.zarr map.png
    """
    found = ReachabilityMap.open(path)
    with needs_extra("a figure", "reach", "matplotlib"):
        from ulna.reachability.plot import draw  # noqa: PLC0415 -- needs the extra
    write_figure(draw(found), out, "out")
    return Output({"figure": str(out), **map_data(found, None, 0)}, map_table)


@GROUP.command("show")
@command
def show_map(path: MapPath, loading: Loading, page: OnPage, *, robot: RobotOfMap = None) -> None:
    """Show a map in the browser: colored voxels, a clipping plane, the robot inside; click a voxel for its solutions.

    Example: ulna reach show map.zarr. Ctrl-C ends it.
    """
    found = ReachabilityMap.open(path, robot=None if robot is None else load_robot(loading, robot=robot))
    with needs_extra("the view", "viewer", "viser", "trimesh"):
        from ulna.viewer.map_view import MapView  # noqa: PLC0415 -- needs the extra
    shown = MapView(found, host=page.host, port=page.port)
    with shown, suppress(KeyboardInterrupt):
        if page.open_browser:
            shown.page.open()
        typer.echo(f"{printable(found.robot.name)} is at {shown.url}  (Ctrl-C ends it)")
        shown.wait()


def map_data(found: ReachabilityMap, seconds: float | None, poses: int) -> Data:
    """Collect the contents of a map; see ``REACH_KEYS``. This run computed ``poses`` poses in ``seconds``."""
    summary = found.summary
    ran = seconds is not None and poses > 0
    return {
        "path": str(found.path),
        "robot": found.attributes["robot"],
        "link": found.link,
        "poses": summary.poses,
        "computed": summary.computed,
        "reached": summary.reached,
        "share": summary.reached / summary.computed if summary.computed else None,
        "statuses": summary.statuses,
        "seconds": seconds if ran else None,
        "poses_a_second": poses / seconds if ran and seconds else None,
    }


def map_table(data) -> Iterator[RenderableType]:
    """Show the number of poses with each status."""
    yield Text.assemble(
        (f"{data['robot']}: {data['link']}", "bold"), f", {data['computed']:,} of {data['poses']:,} poses computed"
    )
    table = make_table(["status"], ["poses", "share"], [])
    for status, count in sorted(data["statuses"].items(), key=lambda item: -item[1]):
        table.add_row("reached" if status == "solved" else status, f"{count:,}", f"{100 * count / data['computed']:.1f} %")
    yield table
    if data["seconds"] is not None:
        yield f"{data['seconds']:.1f} s, {data['poses_a_second']:,.0f} poses/s"
    yield Text(data.get("figure", data["path"]), no_wrap=True)
