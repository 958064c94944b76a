"""Compiled integration methods, one file each; see :func:`mbdsl.integrators.modules`."""
