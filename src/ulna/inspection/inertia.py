"""Checks inertia: zero, or not possible for a body. Used by ``inspect``."""

from collections.abc import Iterator

import numpy as np
from lxml import etree

from ulna.inspection.elements import listed, number, of_robot
from ulna.inspection.result import Finding, Severity

_ZERO = 1e-12  # relative to the largest moment
_ROUNDING = 1e-3  # relative: published inertias have three digits


def inertia_findings(root: etree._Element) -> Iterator[Finding]:
    """Masses that are not positive, and inertias that are not positive definite or break the triangle inequality."""
    massless: list[str] = []
    for link in root.iterfind("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        where, line = of_robot(link), inertial.sourceline
        mass, moments = number(inertial.find("mass"), "value"), _principal_moments(inertial.find("inertia"))
        if mass == 0 and moments is not None and not moments.any():
            massless.append(link.get("name", ""))
            continue
        if mass is None or mass <= 0:
            yield Finding(Severity.WARNING, where, "mass is missing" if mass is None else f"mass is {mass:g} kg", line)
        if moments is None:
            yield Finding(Severity.WARNING, where, "inertia is missing, or not six numbers", line)
        elif not moments.any():
            yield Finding(Severity.WARNING, where, "inertia is zero", line)
        elif moments[0] <= _ZERO * moments[2]:
            least = "0" if abs(moments[0]) <= _ZERO * moments[2] else f"{moments[0]:.3g}"
            yield Finding(Severity.WARNING, where, f"inertia is not positive definite: a moment of {least}", line)
        elif moments[0] + moments[1] < moments[2] * (1 - _ROUNDING):
            message = f"inertia of no body: moments {moments[0]:.3g} + {moments[1]:.3g} < {moments[2]:.3g}"
            yield Finding(Severity.WARNING, where, message, line)
    if massless:
        yield Finding(Severity.NOTE, "document", f"mass and inertia are zero: {listed(massless)}")


def _principal_moments(inertia: etree._Element | None) -> np.ndarray | None:
    """The eigenvalues, ascending."""
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    values = [number(inertia, key) for key in keys]
    if None in values:
        return None
    xx, xy, xz, yy, yz, zz = values
    return np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64))
