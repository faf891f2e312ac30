"""Runs the command line program ``ulna``."""

from ulna.cli.quiet_imports import quiet_imports


def main() -> None:
    """Run the command line, and end the process with its exit status."""
    with quiet_imports():
        from ulna.cli.app import app  # noqa: PLC0415 - it takes a third of a second, during which Ctrl-C may come

    app(prog_name="ulna")


if __name__ == "__main__":
    main()
