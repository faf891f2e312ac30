"""Renders pictures and videos of any robot without a display. Used by ``ulna record`` and the demo.

The film's renderer stays, since nothing lighter renders without a display: a browser, off-screen OpenGL or a ray tracer
would have to be installed beside Python. Its formulas are in ``kernels.render``, its loops over pixels in ``drivers.rendering``.
"""
