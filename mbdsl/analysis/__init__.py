"""Equilibria, and small motions about a state: eigenvalues, eigenmodes, and the tangent bases that they use."""
