"""Fixtures that run the command inside this process, and small robots for it."""

from command_fixtures import ask, odd, refusal, run, slider, wedge, xacro

__all__ = ["ask", "odd", "refusal", "run", "slider", "wedge", "xacro"]
