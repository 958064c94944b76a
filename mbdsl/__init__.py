"""mbdsl: a Modelica-style declarative tool for multibody dynamics."""

__version__ = "0.1.0"
