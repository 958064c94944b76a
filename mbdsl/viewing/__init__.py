"""Motion of planar mechanisms as pages: poses over time, shapes of bodies and elements, and a player in one HTML file."""
