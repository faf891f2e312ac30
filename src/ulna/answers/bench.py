"""What was measured, as data."""

BENCH_KEYS = (
    "machine; fk, jacobian, ik, collision: robot, work, median_ns, lower_ns and upper_ns (quartiles) of one problem, per_second; "
    "protocols; tracking; first_use; memory; size. Each is a list of rows."
)
