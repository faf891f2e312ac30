"""Computes maps of the poses that a robot reaches, in chunks, on all cores or a Dask cluster."""
