"""The peers, a file each: ``make(robot)`` builds a ``Peer`` for an arm, or says why there is none for it."""
