"""Defines the error for a document that asks for what it may not have. Used by the modules of this folder."""


class RefusedError(Exception):
    """A document asked for what it may not have."""
