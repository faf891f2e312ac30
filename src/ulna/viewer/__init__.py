"""Pages and pictures: ``view`` shows any robot, ``app`` the demo, ``record`` paints. The only importer of viser and trimesh."""
