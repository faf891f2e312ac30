"""The command, run inside this process, and arms to run it on."""

from command_fixtures import ask, odd, refusal, run, slider, wedge, xacro

__all__ = ["ask", "odd", "refusal", "run", "slider", "wedge", "xacro"]
