"""Bodies: for every kind its kernels and, with arrays, the model that the rest of the system sees."""
