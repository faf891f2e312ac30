"""The assignment's demo. Used by nothing in the package; entry points add its commands and its film."""
