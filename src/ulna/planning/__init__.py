"""Planning: collision-free paths, constraints and trajectories."""
