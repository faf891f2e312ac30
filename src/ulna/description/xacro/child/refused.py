"""Defines the error for a document that does something forbidden."""


class RefusedError(Exception):
    """A document asked for what it may not have."""
