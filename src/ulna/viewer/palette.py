"""Colours (red, green, blue in 0..255) and opacities of everything drawn.

Free and touching shapes also differ in lightness or opacity, for people who cannot distinguish red from green.
"""

Color = tuple[int, int, int]

GREEN: Color = (40, 180, 75)  # nothing touches
RED: Color = (225, 45, 45)  # something touches, or a target is not reached
UNKNOWN: Color = (150, 150, 150)  # not checked
INK: Color = (40, 45, 52)  # words and lines
FREE: Color = (90, 140, 220)  # collision shapes of the robot
TOUCHING: Color = RED
MOVABLE: Color = (240, 170, 40)  # obstacles
GROUND: Color = (150, 160, 172)  # half-spaces among them
PALE, STRONG = 0.2, 0.75  # opacities of the robot's collision shapes: free, touching


def obstacle_opacity(*, touching: bool) -> float:
    """The opacity of an obstacle."""
    return 1.0 if touching else 0.6
