"""The error of a document that reaches for what it may not have."""


class RefusedError(Exception):
    """A document reached for what it may not have."""
