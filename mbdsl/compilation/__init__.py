"""Compilation of kernels to machine code: marks, layout of the buffers, compiler, and the cache of compiled code."""
