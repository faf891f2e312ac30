"""Solutions of the exercises of the lessons. `docs/site/exercises.py` puts each behind its exercise on the documentation site."""

import numpy as np

import ulna

robot = ulna.load("panda")


# ---- lesson 1 ----


def standard_row(a, d, alpha, theta):
    return ulna.pose((0, 0, d), (0, 0, theta)) @ ulna.pose((a, 0, 0), (alpha, 0, 0))


def seen_from_the_hand(q, p_base):
    T_hand_base = np.linalg.inv(robot.forward_kinematics(q))
    return (T_hand_base @ [*p_base, 1])[:3]


# ---- lesson 2 ----


def jacobian_of(kinds, z, o, p):
    columns = []
    for kind, z_i, o_i in zip(kinds, z, o, strict=True):
        turns = kind == "revolute"
        columns.append(np.concatenate([np.cross(z_i, p - o_i), z_i] if turns else [z_i, np.zeros(3)]))
    return np.array(columns).T


def lost_direction(J):
    U, _, _ = np.linalg.svd(J)
    return U[:, -1]


# ---- lesson 3 ----


def damped_step(J, e, damping):
    return J.T @ np.linalg.solve(J @ J.T + damping * np.eye(len(e)), e)


def starts_needed(p, wanted):
    return int(np.ceil(np.log(1 - wanted) / np.log(1 - p) - 1e-9))


# ---- lesson 4 ----


def box_shadow(T, half, n):
    center, reach = T[:3, 3] @ n, half @ np.abs(T[:3, :3].T @ n)
    return center - reach, center + reach


def way_out(T_a, half_a, T_b, half_b):
    width, n = widest_gap(T_a, half_a, T_b, half_b)  # noqa: F821 - the lesson's own
    away = n if (T_b[:3, 3] - T_a[:3, 3]) @ n >= 0 else -n
    return -width * away


# ---- lesson 5 ----


def shortcut(path, is_free):
    short, at = [path[0]], 0
    while at < len(path) - 1:
        at = max(k for k in range(at + 1, len(path)) if k == at + 1 or is_free(path[at], path[k]))
        short.append(path[at])
    return np.array(short)


def certainly_free(q_a, q_b, least=1e-5):
    middle = (q_a + q_b) / 2
    distance, moved = clearance(middle), reach(q_b - q_a) / 2  # noqa: F821 - the lesson's own
    if distance > moved:
        return True
    if distance <= 0 or moved < least:
        return False
    return certainly_free(q_a, middle, least) and certainly_free(middle, q_b, least)


# ---- lesson 6 ----


def two_angles(a, b, c):
    length, direction = np.hypot(a, b), np.arctan2(b, a)  # length cos(x - direction) = c
    if abs(c) > length:
        return []
    return [direction + np.arccos(c / length), direction - np.arccos(c / length)]


def nearest_branch(branches, seed, lower, upper):
    turn, found = 2 * np.pi, []
    for q in branches:
        near = q - turn * np.rint((q - seed) / turn)  # the nearest; if it is beyond a limit, the first one within
        near += turn * np.ceil(np.maximum(lower - near, 0) / turn)
        near -= turn * np.ceil(np.maximum(near - upper, 0) / turn)
        if np.all((lower <= near) & (near <= upper)):
            found.append(near)
    return min(found, key=lambda q: np.abs(q - seed).max(), default=None)


# ---- lesson 7 ----


def heaviest(own, per_kilogram, most):
    if np.any(np.abs(own) > most):
        return 0.0
    room = most - np.sign(per_kilogram) * own  # what a motor has left in the direction in which the mass pulls
    return np.min(room / np.abs(per_kilogram))


def mass_matrix_of(torques, q):
    n = len(q)
    still = torques(q, np.zeros(n), np.zeros(n))
    return np.array([torques(q, np.zeros(n), unit) - still for unit in np.eye(n)]).T
