"""Animations of models in space: poses, solids, arrows, and the page that draws them with three.js."""
