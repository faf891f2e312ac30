"""``ulna servo``: steers a robot's hand on a page, clear of obstacles."""

from ulna.cli.cell import Obstacles, ShownRobot
from ulna.cli.depends import command
from ulna.cli.mount import FreeFall, mounted
from ulna.cli.options import Jerk, OnPage
from ulna.cli.targets import BeginningQ
from ulna.cli.view import serve
from ulna.viewer.open_page import view


@command
def servo(robot: ShownRobot, world: Obstacles, q: BeginningQ, page: OnPage, free_fall: FreeFall, *, jerk: Jerk = None) -> None:
    """Steer a robot's hand in the browser with buttons or arrow keys; it touches nothing and shows its limits.

    Shift with a key turns the hand. Ctrl-C ends it.
    """
    serve(view(mounted(robot, free_fall), world, q=q, steer=True, jerk=jerk, **page._asdict()))
