"""A robot against itself and a world: broad and narrow phase. Used by the drivers of ``ulna.collision``."""
