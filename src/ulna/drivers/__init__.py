"""Entries: each owns its workspaces and runs kernels over a batch, eight problems at a time. Used by NumPy's side of Ulna."""
