"""Writes the meshes of the desk arm as OBJ files in meters: tapered links along z, with eight sides."""

from pathlib import Path

import numpy as np

SIDES = 8
LINKS = {  # height and radius of each ring [m]
    "foot": ((0.0, 0.07), (0.02, 0.07), (0.05, 0.04)),
    "turret": ((0.0, 0.04), (0.07, 0.035)),
    "upper_arm": ((-0.03, 0.02), (0.0, 0.03), (0.22, 0.022), (0.24, 0.015)),
    "forearm": ((-0.02, 0.015), (0.0, 0.022), (0.18, 0.016), (0.195, 0.01)),
    "pen": ((0.0, 0.012), (0.06, 0.01), (0.09, 0.001)),
}


def as_obj(rings):
    """An OBJ file of rings joined by quadrilaterals, with a polygon at either end; counterclockwise from outside."""
    turns = 2 * np.pi * np.arange(SIDES) / SIDES
    lines = [f"v {r * np.cos(a):.5f} {r * np.sin(a):.5f} {z:.5f}" for z, r in rings for a in turns]
    around = [(s + 1, (s + 1) % SIDES + 1) for s in range(SIDES)]
    for k in range(0, SIDES * (len(rings) - 1), SIDES):
        lines += [f"f {k + a} {k + b} {k + SIDES + b} {k + SIDES + a}" for a, b in around]
    last = SIDES * (len(rings) - 1)
    ends = (range(SIDES, 0, -1), range(last + 1, last + SIDES + 1))
    return "\n".join([*lines, *("f " + " ".join(map(str, end)) for end in ends)]) + "\n"


if __name__ == "__main__":
    for name, rings in LINKS.items():
        Path(__file__).with_name("meshes").joinpath(f"{name}.obj").write_text(as_obj(rings))
