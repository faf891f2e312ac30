"""Defines the error for a document that does something forbidden. Used by the modules of this folder."""


class RefusedError(Exception):
    """A document asked for what it may not have."""
