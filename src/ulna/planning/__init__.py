"""From a pose to a motion: plans, trajectories."""
