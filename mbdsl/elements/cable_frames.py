"""Stub."""

MASS = 1
stiffness = None
