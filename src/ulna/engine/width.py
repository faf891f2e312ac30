"""How many problems a lane number holds. Used by the lanes, the drivers and the code that lays out tables for them."""

WIDTH = 8
