"""The assignment's demo: a guest, which the rest of the package does not import."""
