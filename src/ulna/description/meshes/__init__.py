"""The mesh files of a description."""
