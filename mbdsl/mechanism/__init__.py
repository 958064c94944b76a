"""The mechanism before any number is computed: the Scene, its graph, and the reduced scene that is solved for."""
