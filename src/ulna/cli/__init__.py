"""The command line ``ulna``: one file a command, with its options, its data (``--json``) and its table."""
