"""Rasterizing and shading of pictures."""
