"""Shows any robot: ``view`` on a page, ``session`` without the page, ``film`` as pictures. Used by the command line, the demo.

Only this package and the demo's page import viser.
"""
