"""The compiled integration methods, one file each, which :func:`mbdsl.integrators.modules` discovers."""
