"""Maps of the poses that a robot reaches, computed in chunks on every core or on a Dask cluster, kept by Zarr."""
