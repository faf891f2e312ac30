"""Rasterising and shading of pictures. Used by ``drivers.rendering``."""
