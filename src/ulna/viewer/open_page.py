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
    """Show a robot on a page: drag its hand, move its joints, steer it, add obstacles. The program continues.

    Args:
        robot: The robot.
        world: The obstacles, which the page shows and changes; an empty world unless given.
        q: The first joint positions [rad or m], shape (n_dof,). Default: the SRDF's `home`, or else ``robot.home``.
        host: The address to listen on. Only with 127.0.0.1, localhost and ::1 can no other machine connect.
        port: The TCP port; a free one unless given.
        open_browser: Whether to open the page in a browser of this machine, if there is one.
        origins: Origins of other pages that may connect, such as ``"https://hub.example.org"`` of a proxy.
        steer: Whether to begin with the tab Steer, where buttons and keys move the hand with a servo that avoids contact.
        jerk: The jerk limit of each joint while it is steered [rad/s^3 or m/s^3]; no limit unless given.

    Returns:
        A ``View``: ``url``; ``q``, which can be set; ``world``; ``stop()``. It stops at the end of a ``with`` block. Jupyter
        shows it in a frame.

    Raises:
        InputError: The server cannot listen on the address, or the robot, the world, q or the jerk is invalid. No page is opened.
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
