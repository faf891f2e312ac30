"""Benchmarks of Ulna and its peers: ``make bench``. The package does not import them."""
