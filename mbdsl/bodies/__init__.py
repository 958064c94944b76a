"""Bodies: the kernels of every kind, and the NumPy model through which the other packages access it."""
