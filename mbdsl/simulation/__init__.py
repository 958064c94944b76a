"""One run of a model: from its Scene to a Trajectory, at once or step by step."""
