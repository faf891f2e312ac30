"""The subcommands of ``ulna``: each reads its options, calls the library once or twice and shows the answer."""
