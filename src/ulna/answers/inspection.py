"""The health of a description."""

from dataclasses import asdict

from ulna.answers.plain import Data
from ulna.inspection.result import Inspection, Severity

INSPECTION_KEYS = (
    "source; name; loads: whether Ulna takes it; n_dof and reach (m): null if not; n_links; joint_types: how many of each; "
    "counts: error, warning, note; findings, worst first: severity, where, message, line, tried (the paths where a mesh was "
    "looked for); tree: depth, link, joint, type."
)


def inspection_data(inspection: Inspection) -> Data:
    """The findings and the tree; see ``INSPECTION_KEYS``."""
    return {**asdict(inspection), "counts": {severity.value: inspection.count(severity) for severity in Severity}}
