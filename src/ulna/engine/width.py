"""How many problems a lane number holds."""

WIDTH = 8
