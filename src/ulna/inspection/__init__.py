"""The health of a robot description: what is wrong and what looks wrong, also in a file that cannot be loaded."""
