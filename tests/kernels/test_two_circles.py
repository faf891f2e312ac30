"""Pairs of unit vectors with y = u - B x: all of them, by the changes of sign of a fine grid, and by those that were planted."""

import numpy as np
import pytest

import closed_form_probes as probes

N = 64
SIGNS = [(line, sign) for line in (1.0, -1.0) for sign in (1.0, -1.0)]


def planted(rng, scale):
    """Matrices B (N, 2, 2), u (N, 2), and the angle of one x for which u - B x is a unit vector."""
    B, x, y = scale * rng.normal(size=(N, 2, 2)), rng.uniform(-np.pi, np.pi, N), rng.uniform(-np.pi, np.pi, N)
    return B, unit(y) + np.einsum("nij,nj->ni", B, unit(x)), x


def unit(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def value(B, u, angle):
    """|u - B x|^2 - 1 for angles (N, k)."""
    return ((u[:, None] - np.einsum("nij,nkj->nki", B, unit(angle))) ** 2).sum(axis=-1) - 1.0


def pairs(run, B, u):
    """The angles of x and y, shape (N, 4), of all four pairs of signs, and whether they are a pair."""
    rows = [
        np.column_stack(
            [u, B[:, 0, 0], B[:, 1, 0], B[:, 0, 1], B[:, 1, 1], np.full(N, line), np.full(N, sign), np.full(N, 1e-14)]
        )
        for line, sign in SIGNS
    ]
    found = np.stack([run(probes.pair_of_circles, row.T, 6) for row in rows], axis=-1)
    np.testing.assert_allclose(found[0] ** 2 + found[1] ** 2, 1.0, atol=1e-9)
    x, y = np.arctan2(found[0], found[1]), np.arctan2(found[4], found[5])
    missed = np.abs(np.einsum("nij,nkj->nki", B, unit(x)) + unit(y) - u[:, None]).max(axis=-1)
    size = 1.0 + np.abs(B).max(axis=(1, 2))[:, None]
    return x, missed < 1e-8 * size


def apart(a, b):
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.03, 0.3, 1.0, 3.0, 30.0, 300.0])
def test_the_pair_that_was_planted_is_found_and_as_many_as_there_are_changes_of_sign(run, scale):
    for seed in range(4):
        B, u, planted_x = planted(np.random.default_rng(seed), scale)
        x, real = pairs(run, B, u)
        nearest = np.where(real, apart(x, planted_x[:, None]), 9.0).min(axis=1)
        assert nearest.max() < 1e-6
        grid = np.linspace(-np.pi, np.pi, 12_001)
        signs = value(B, u, np.tile(grid, (N, 1))) > 0
        changes = (signs[:, 1:] != signs[:, :-1]).sum(axis=1)
        both = real[:, :, None] & real[:, None] & ~np.eye(4, dtype=bool)
        clear = np.where(both, apart(x[:, :, None], x[:, None]), 9.0).min(axis=(1, 2))
        well = clear > 1e-3  # two roots within a step of the grid are no change of sign
        np.testing.assert_array_equal(real.sum(axis=1)[well], changes[well])


@pytest.mark.parametrize("kind", ["turn", "diagonal", "no cosine", "no sine", "projection", "centered"])
def test_in_special_positions_all_are_found(run, kind):
    """B a turn (a straight line is left), diagonal, singular; u along an axis of it, or 0."""
    rng = np.random.default_rng(3)
    B, u, x = planted(rng, 1.0)
    turns = np.stack([unit(x), unit(x + np.pi / 2)], axis=-1)
    if kind == "turn":
        B = 1.3 * turns
    elif kind == "projection":
        B[:, :, 1] = 0.0
    elif kind != "centered":
        B = np.array([[1.4, 0.0], [0.0, 0.7]]) * np.ones((N, 1, 1))
    u = unit(rng.uniform(-3, 3, N)) + np.einsum("nij,nj->ni", B, unit(x))
    if kind == "no cosine":
        u[:, 0], x = 0.0, np.arccos(rng.uniform(-0.7, 0.7, N))
        u[:, 1] = 0.7 * np.sin(x) + np.sqrt(1 - (1.4 * np.cos(x)) ** 2)
    if kind == "no sine":
        x = np.arcsin(rng.uniform(-1, 1, N))
        u[:, 1], u[:, 0] = 0.0, 1.4 * np.cos(x) + np.sqrt(1 - (0.7 * np.sin(x)) ** 2)
    if kind == "centered":
        u[:] = 0.0
        B = np.array([[2.0, 0.3], [0.1, 0.4]]) * np.ones((N, 1, 1))
        x[:] = np.nan
    found, real = pairs(run, B, u)
    if kind == "centered":
        assert (real.sum(axis=1) == 4).all()
    else:
        assert np.where(real, apart(found, x[:, None]), 9.0).min(axis=1).max() < 1e-6
    if kind == "turn":
        assert (real.sum(axis=1) <= 2).all()


def test_where_two_are_one_it_is_found_to_half_the_digits(run):
    """The ellipse touches the circle: y is normal to it."""
    rng = np.random.default_rng(5)
    B, _, x = planted(rng, 1.0)
    tangent = np.einsum("nij,nj->ni", B, unit(x + np.pi / 2))
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1) / np.linalg.norm(tangent, axis=1)[:, None]
    u = normal + np.einsum("nij,nj->ni", B, unit(x))
    found, _ = pairs(run, B, u)
    assert apart(found, x[:, None]).min(axis=1).max() < 1e-6


def test_where_three_are_one_no_pair_near_it_is_said_to_be_complex_for_certain(run):
    """y is normal to B x', and y . B x = -|B x'|^2, so the first and the second derivative are 0 as well."""
    rng = np.random.default_rng(6)
    x = rng.uniform(-np.pi, np.pi, N)
    ahead, across = unit(x), unit(x + np.pi / 2)
    tangent = rng.uniform(0.3, 1.5, N)[:, None] * unit(rng.uniform(-np.pi, np.pi, N))
    y = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1) / np.linalg.norm(tangent, axis=1)[:, None]
    along = -(tangent**2).sum(axis=1)[:, None] * y + rng.uniform(-1, 1, N)[:, None] * tangent
    B = np.einsum("ni,nj->nij", along, ahead) + np.einsum("ni,nj->nij", tangent, across)
    rows = [
        np.column_stack(
            [y + along, B[:, 0, 0], B[:, 1, 0], B[:, 0, 1], B[:, 1, 1], np.full(N, line), np.full(N, sign), np.full(N, 1e-14)]
        )
        for line, sign in SIGNS
    ]
    found = np.stack([run(probes.pair_of_circles, row.T, 6) for row in rows], axis=-1)
    near = apart(np.arctan2(found[0], found[1]), x[:, None]) < 1e-2
    assert near.sum() >= 2 * N
    assert found[3][near].min() > -1e-30


# ---- that a line passes the circle for certain

HARMONICS = 5


def of_roots(roots):
    """k, a, b, d, shape (4, n), of the product of the sines of half the distances from roots (n, 4), and the sum of their sizes.

    The angle is counted from where sin 2 angle has no part and d >= 0. Complex roots come in pairs.
    """
    t = np.arange(HARMONICS) * 2 * np.pi / HARMONICS
    values = np.prod(np.sin((t[:, None, None] - roots) / 2), axis=-1).real
    terms = np.column_stack([np.ones(HARMONICS), np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)])
    k, a, b, c_2, s_2 = np.linalg.solve(terms, values)
    turn = np.arctan2(s_2, c_2) / 2
    form = np.stack([k, a * np.cos(turn) + b * np.sin(turn), b * np.cos(turn) - a * np.sin(turn), np.hypot(c_2, s_2)])
    return form / np.abs(form).sum(axis=0)


def changes_of_sign(form):
    """How often k + a cos + b sin + d cos 2 angle changes its sign, by its values between the angles of its roots."""
    k, a, b, d = form
    roots = np.roots([d / 2, (a - 1j * b) / 2, k, (a + 1j * b) / 2, d / 2])
    ends = np.sort(np.concatenate([np.angle(roots), np.linspace(-np.pi, np.pi, 40)]))
    t = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
    positive = k + a * np.cos(t) + b * np.sin(t) + d * np.cos(2 * t) > 0
    return int((positive != np.roll(positive, 1)).sum())


@pytest.mark.parametrize("kind", ["two real", "none real"])
def test_what_passes_for_certain_has_no_root_though_the_equation_be_off(run, kind):
    """Roots of all distances, nearly double to fourfold ones among them; the equation is then changed by what it is off by."""
    rng = np.random.default_rng(8)
    n = 400
    near, height, middle = 10.0 ** rng.uniform(-4, 0, n), 10.0 ** rng.uniform(-4, 0.3, n), rng.uniform(-np.pi, np.pi, n)
    if kind == "two real":
        first = np.stack([middle, middle + near * rng.normal(size=n)], axis=-1) + 0j
    else:
        first = np.stack([middle + 1j * height, middle - 1j * height], axis=-1)
    other = middle + near * rng.normal(size=n) + 1j * height * 10.0 ** rng.uniform(-1, 1, n)
    form = of_roots(np.column_stack([first, other, other.conj()]))
    form = form[:, form[3] > 1e-8]  # else it is a straight line
    off = 10.0 ** rng.uniform(-7, -2, form.shape[1])
    passing = run(probes.pair_of_lines, np.vstack([form, off]), 2) > 0.0
    assert 0.02 < passing.mean() < 0.9
    change = rng.normal(size=(6, *form.shape))
    change[:3] = np.eye(4)[0][:, None] * rng.choice([-1.0, 1.0], size=(3, 1, form.shape[1]))
    for off_by in change / np.abs(change).sum(axis=1, keepdims=True) * off:
        counted = np.array([changes_of_sign(changed) for changed in (form + off_by).T])
        assert (counted <= 4 - 2 * passing.sum(axis=0)).all()
