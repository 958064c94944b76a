"""The step loop that compiled methods share, and the numerics of a step."""
