"""The version of mbdsl."""

__version__ = "0.1.0"
