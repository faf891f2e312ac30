"""The peers, one per file: ``make(robot)`` builds a ``Peer`` for an arm, or raises an error with the reason."""
