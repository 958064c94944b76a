"""Jupyter notebooks and IPython: the cell magic."""
