"""Backends that come with mbdsl: integrators of others, one file each. What they need is imported when they run."""
