"""Ulna side by side with its peers: ``make bench``. Nothing of the package imports this."""
