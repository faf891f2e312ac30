"""What was measured, as data."""

BENCH_KEYS = (
    "machine; fk, jacobian, ik, collision: robot, work, median_ns, lower_ns and upper_ns (quartiles) of one problem, per_second; "
    "protocols; tracking; first_use; memory; size; left_out: what was not measured, and why. Each is a list of rows."
)
