"""How two descriptions of one robot differ."""
