"""What Python calls: each entry owns its workspaces and runs kernels over a batch, eight problems at a time."""
