"""Steers an arm tick by tick, each command certified together with a full stop after it."""
