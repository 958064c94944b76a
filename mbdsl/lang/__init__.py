"""The language: from text to syntax tree to Scene, in pure Python, without importing numerics."""
