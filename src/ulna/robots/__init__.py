"""Bundled descriptions, and what a URDF cannot say of them."""
