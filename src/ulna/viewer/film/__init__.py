"""Renders pictures and videos of any robot without a display.

It has its own renderer, since the alternatives (a browser, off-screen OpenGL, a ray tracer) would have to be installed beside
Python. Its formulas are in ``kernels.render``, its loops over pixels in ``viewer.film.entries.rendering``.
"""
