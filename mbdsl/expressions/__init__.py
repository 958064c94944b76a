"""Symbolic expressions of the language, with exact derivatives."""
