"""Motion of mechanisms as pages: poses over time, shapes of bodies and elements, a player in one HTML file."""
