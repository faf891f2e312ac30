"""Renders pictures and videos of any robot without a display.

It has its own renderer, since the alternatives (a browser, off-screen OpenGL, a ray tracer) need more than Python packages. The
formulas are in ``kernels.render``, the loops over pixels in ``viewer.film.entries.rendering``.
"""
