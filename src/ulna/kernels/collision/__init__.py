"""A robot against itself and a world: broad and narrow phase."""
