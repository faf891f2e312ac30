"""The assignment's demo."""
