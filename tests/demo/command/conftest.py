"""Fixtures that run the command inside this process."""

from command_fixtures import ask, refusal, run

__all__ = ["ask", "refusal", "run"]
