"""The assignment's demo: a guest. Used by nothing in the package; entry points add its commands and its film."""
