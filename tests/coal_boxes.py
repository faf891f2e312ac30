"""Checks boxes with Coal at its highest accuracy. ``crosscheck/test_coal.py`` states that accuracy."""

import coal


def as_coal(extents, T):
    return coal.Box(*extents), coal.Transform3s(T[:3, :3], T[:3, 3])


def overlap(a, b) -> bool:
    return coal.collide(*a, *b, _exacting(coal.CollisionRequest()), coal.CollisionResult()) > 0


def distance(a, b) -> float:
    """Negative when penetrating."""
    return coal.distance(*a, *b, _exacting(coal.DistanceRequest()), coal.DistanceResult())


def _exacting(request):
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    return request
