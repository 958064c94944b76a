"""What kernels are written with: the names of the buffers that they work on, and the marks of what is compiled."""
