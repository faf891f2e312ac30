"""The description of a robot: read from files into immutable data."""
