"""Solves a strictly convex quadratic program exactly, from a point that satisfies its constraints.

It minimizes x' H x / 2 - f' x subject to g_i' x >= b_i for each constraint i.

The method is a primal active-set method with the Schur complement of the active constraints. Source: Nocedal and Wright,
Numerical Optimization, 2nd ed., algorithm 16.3 and section 16.2. With H = L L', z = L' x - L^-1 f, and Y the columns L^-1 g_i of
the active constraints:

1. Solve Y' Y m = Y' z for the multipliers m. The step p to the minimum on the active constraints is L'^-1 (Y m - z).
2. If there is no step, release the active constraint with the smallest multiplier. If none is negative, x is the minimum.
3. Otherwise move x by p, or until a constraint blocks it. That constraint becomes active.

Every x on the way satisfies all constraints. So does the result if the number of rounds ends the search.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt

_ROUNDS_PER_ROW = 3  # rounds per constraint and unknown, at most
_TOLERANCE = 1e-9  # relative to z: smaller steps and multipliers count as 0
_PARALLEL = 1e-8  # relative to constraint and step: the step is parallel to the constraint
_MIN_PIVOT = 1e-13  # relative to the diagonal entry


@routine
def minimize(factor_rows, f_rows, program, m, x_rows):
    """Write the minimum to x; return the number of active constraints, whose numbers and multipliers are written.

    factor_rows: H, n n numbers; it is overwritten. program: A ``Program`` of m constraints. f is overwritten with L^-1 f.
    """
    n, normal_rows, bound_rows = x_rows.shape[0], program.normal_rows, program.bound_rows
    active_rows, multiplier_rows, work_rows = program.active_rows, program.multiplier_rows, program.work_rows
    y_rows, schur_rows = work_rows[: n * n], work_rows[n * n : 2 * n * n]
    z_rows, step_rows = work_rows[2 * n * n : 2 * n * n + n], work_rows[2 * n * n + n : 2 * n * n + 2 * n]
    factorize(factor_rows, n, n)
    forward(factor_rows, n, n, f_rows)
    k, size = 0, 1e-300
    for i in range(n):
        size = max(size, abs(f_rows[i]))
    for _ in range(_ROUNDS_PER_ROW * (m + n)):
        size = max(size, write_gradient_of(factor_rows, f_rows, x_rows, z_rows))
        write_schur(k, n, y_rows, z_rows, schur_rows, multiplier_rows)
        factorize(schur_rows, k, n)
        forward(schur_rows, k, n, multiplier_rows)
        backward(schur_rows, k, n, multiplier_rows)
        longest = write_step(k, multiplier_rows, y_rows, z_rows, step_rows)
        if longest <= _TOLERANCE * size or k == n:
            worst = smallest_multiplier(k, multiplier_rows, -_TOLERANCE * size)
            if worst < 0:
                return k
            k = release(worst, k, n, active_rows, multiplier_rows, y_rows)
            continue
        backward(factor_rows, n, n, step_rows)
        share, blocking = first_blocking(normal_rows, bound_rows, m, x_rows, active_rows, k, step_rows)
        for i in range(n):
            x_rows[i] += share * step_rows[i]
        if blocking >= 0:
            active_rows[k] = blocking
            for i in range(n):
                y_rows[n * k + i] = normal_rows[n * blocking + i]
            forward(factor_rows, n, n, y_rows[n * k : n * k + n])
            k += 1
    return k


@routine
def solve_on_rows(factor_rows, normal_rows, active_rows, value_rows, k, x_rows, work_rows):
    """Solve H x = b on k active constraints, where g' x = v. b is passed in x.

    v is overwritten by the multipliers. factor_rows and work_rows are as ``minimize`` leaves them.
    """
    n = x_rows.shape[0]
    y_rows, schur_rows = work_rows[: n * n], work_rows[n * n : 2 * n * n]
    multiplier_rows = work_rows[2 * n * n : 2 * n * n + n]
    forward(factor_rows, n, n, x_rows)
    for a in range(k):
        for i in range(n):
            y_rows[n * a + i] = normal_rows[n * active_rows[a] + i]
        forward(factor_rows, n, n, y_rows[n * a : n * a + n])
    write_schur(k, n, y_rows, x_rows, schur_rows, multiplier_rows)
    for a in range(k):
        value_rows[a] = multiplier_rows[a] - value_rows[a]
    factorize(schur_rows, k, n)
    forward(schur_rows, k, n, value_rows)
    backward(schur_rows, k, n, value_rows)
    for a in range(k):
        for i in range(n):
            x_rows[i] -= value_rows[a] * y_rows[n * a + i]
    backward(factor_rows, n, n, x_rows)


@kernel
def write_gradient_of(factor_rows, f_rows, x_rows, z_rows):
    """Write z = L' x - L^-1 f; return its largest entry."""
    n, largest = x_rows.shape[0], 0.0
    for i in range(n):
        total = -f_rows[i]
        for j in range(i, n):
            total += factor_rows[n * j + i] * x_rows[j]
        z_rows[i] = total
        largest = max(largest, abs(total))
    return largest


@kernel
def write_step(k, multiplier_rows, y_rows, z_rows, step_rows):
    """Write Y m - z, which is L' times the step; return its largest entry."""
    n, longest = z_rows.shape[0], 0.0
    for i in range(n):
        total = -z_rows[i]
        for a in range(k):
            total += multiplier_rows[a] * y_rows[n * a + i]
        step_rows[i] = total
        longest = max(longest, abs(total))
    return longest


@kernel
def smallest_multiplier(k, multiplier_rows, below):
    """Step 2: index of the smallest multiplier below a bound; -1 for none."""
    worst, least = -1, below
    for a in range(k):
        if multiplier_rows[a] < least:
            worst, least = a, multiplier_rows[a]
    return worst


@kernel
def write_schur(k, n, y_rows, z_rows, schur_rows, multiplier_rows):
    """Step 1: write the lower triangle of Y' Y, and Y' z in place of the multipliers."""
    for a in range(k):
        for b in range(a + 1):
            total = 0.0
            for i in range(n):
                total += y_rows[n * a + i] * y_rows[n * b + i]
            schur_rows[n * a + b] = total
        total = 0.0
        for i in range(n):
            total += y_rows[n * a + i] * z_rows[i]
        multiplier_rows[a] = total


@kernel
def release(worst, k, n, active_rows, multiplier_rows, y_rows):
    """Step 2: remove an active constraint; return the number of those left."""
    for a in range(worst, k - 1):
        active_rows[a], multiplier_rows[a] = active_rows[a + 1], multiplier_rows[a + 1]
        for i in range(n):
            y_rows[n * a + i] = y_rows[n * (a + 1) + i]
    return k - 1


@kernel
def first_blocking(normal_rows, bound_rows, m, x_rows, active_rows, k, step_rows):
    """Step 3: share of the step up to the first constraint that blocks it, and that constraint; else 1.0, -1."""
    n, share, blocking = x_rows.shape[0], 1.0, -1
    for r in range(m):
        along, value, size = 0.0, 0.0, 0.0
        for i in range(n):
            g, step = normal_rows[n * r + i], step_rows[i]
            along += g * step
            value += g * x_rows[i]
            size += abs(g * step)
        if along < -_PARALLEL * size:
            here = max(bound_rows[r] - value, -1e300) / along
            if here < share:
                is_active = False
                for a in range(k):
                    is_active = is_active or active_rows[a] == r
                if not is_active:
                    share, blocking = max(here, 0.0), r
    return share, blocking


@kernel
def factorize(rows, k, n):
    """Compute the lower Cholesky factor of k rows of n numbers, in place.

    A row that depends linearly on others gets a smallest pivot.
    """
    for r in range(k):
        for c in range(r + 1):
            total = diagonal = rows[n * r + c]
            for i in range(c):
                total -= rows[n * r + i] * rows[n * c + i]
            if r == c:
                rows[n * r + r] = sqrt(max(total, _MIN_PIVOT * diagonal + 1e-300))
            else:
                rows[n * r + c] = total / rows[n * c + c]


@kernel
def forward(factor_rows, k, n, x_rows):
    """Solve x = L^-1 x for the first k numbers."""
    for r in range(k):
        total = x_rows[r]
        for c in range(r):
            total -= factor_rows[n * r + c] * x_rows[c]
        x_rows[r] = total / factor_rows[n * r + r]


@kernel
def backward(factor_rows, k, n, x_rows):
    """Solve x = L'^-1 x for the first k numbers."""
    for back in range(k):
        r = k - 1 - back
        total = x_rows[r]
        for c in range(r + 1, k):
            total -= factor_rows[n * c + r] * x_rows[c]
        x_rows[r] = total / factor_rows[n * r + r]
