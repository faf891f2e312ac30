"""The demo in RViz. Only here are quaternions xyzw."""
