"""Shows any robot: ``view`` on a page, ``session`` without the page, ``film`` as pictures.

Only this package and the demo's page import viser.
"""
