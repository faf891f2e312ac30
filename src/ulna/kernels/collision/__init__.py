"""A robot against itself and a world: BVH, overlap, nearest pair, contacts, continuous collision checking."""
