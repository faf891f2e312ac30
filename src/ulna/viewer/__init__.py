"""Shows any robot: ``view`` on a page in the browser, ``film`` as pictures and videos.

``session`` holds the state of a view and computes it without a page. Only this package and the demo's page import viser.
"""
