"""The language: text to syntax tree to Scene. Pure Python; no numerics are imported here."""
