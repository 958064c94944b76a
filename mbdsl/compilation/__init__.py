"""Kernels to machine code: marks, layout of the buffers, compilation, and the cache of compiled code."""
