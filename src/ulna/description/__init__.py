"""A robot as its file says: files in, frozen data out."""
