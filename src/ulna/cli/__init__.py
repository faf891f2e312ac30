"""The command line ``ulna``: one file for each command, with its options, its data (``--json``) and its table."""
