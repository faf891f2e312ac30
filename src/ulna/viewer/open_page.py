"""Opens a page that shows a robot while the program continues: ``ulna.view``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ulna.collision.world import World
from ulna.description.arrays import as_switch
from ulna.errors import needs_extra
from ulna.robot import Robot

if TYPE_CHECKING:
    from ulna.viewer.view import View


def view(
    robot: Robot,
    world: World | None = None,
    *,
    q: ArrayLike | None = None,
    host: str = "127.0.0.1",
    port: int = 0,
    open_browser: bool = False,
    origins: Iterable[str] = (),
    steer: bool = False,
    jerk: float | None = None,
) -> View:
    """Show a robot on a page: drag its hand, move its joints, steer it, add obstacles. Meanwhile the program continues.

    Args:
        robot: The robot.
        world: The obstacles: the page shows and changes them; an empty world unless given.
        q: The first joint positions [rad or m], shape (n_dof,). If not given: the SRDF's `home`, or else ``robot.home``.
        host: The address to listen on; with any but 127.0.0.1, localhost and ::1 other machines can connect.
        port: The TCP port; a free one unless given.
        open_browser: Open a page on this machine, if it has a browser.
        origins: Addresses of other pages that may connect to it, such as ``"https://hub.example.org"`` of a proxy.
        steer: Begin with the tab in which the hand is steered, by buttons and keys, with a servo that touches nothing.
        jerk: The greatest of each joint while it is steered [rad/s^3 or m/s^3]; no limit unless given.

    Returns:
        A ``View``: ``url``; ``q``, which can be set; ``world``; ``stop()``. It stops at the end of a ``with`` block, and Jupyter
        shows it in a frame.

    Raises:
        InputError: The address cannot be listened on, or the robot, the world, q or the jerk is not one; then no page is opened.
        MissingExtraError: The extra ``viewer`` is not installed.

    Example:
        >>> import ulna
        >>> with ulna.view(ulna.load("panda")) as view:
        ...     view.q = [0, 0, 0, -1.5, 0, 1.5, 0.8]
        ...     view.url
        'http://127.0.0.1:...'
    """
    opens = as_switch("open_browser", open_browser)
    with needs_extra("the view", "viewer", "viser", "trimesh"):
        from ulna.viewer.view import View  # noqa: PLC0415 -- needs the extra
    shown = View(robot, world, q=q, host=host, port=port, origins=tuple(origins), steer=steer, jerk=jerk)
    if opens:
        shown.page.open()
    return shown
