"""Runs the command ``ulna``. Used by ``python -m ulna``."""

from ulna.cli.app import app

if __name__ == "__main__":
    app(prog_name="ulna")
