"""Rasterising and shading of pictures."""
