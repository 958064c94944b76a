"""Consistent initial values: placement, positions, velocities, accelerations, and redundant constraints."""
