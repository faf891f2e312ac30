"""Shows any robot: ``view`` on a page, ``session`` without the page, ``film`` as pictures. Used by the command line, the demo.

With the demo's page the only importer of viser.
"""
