"""Figures, tables and pages as data, drawn to picture files and HTML pages."""
