"""The element kinds of models in space: one file each, as in :mod:`mbdsl.elements`, with the same names."""
