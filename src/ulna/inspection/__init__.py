"""The health of a robot description, also of a file that cannot be loaded; and how two descriptions of one robot differ."""
