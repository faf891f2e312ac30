"""Runs the command ``ulna``."""

from ulna.cli.app import app

if __name__ == "__main__":
    app(prog_name="ulna")
