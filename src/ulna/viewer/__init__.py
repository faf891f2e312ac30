"""The view in a browser: ``scene`` draws, ``app`` holds the widgets and the loop. The only importer of viser and trimesh."""
