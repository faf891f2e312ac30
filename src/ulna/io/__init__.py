"""Files in, descriptions out."""
