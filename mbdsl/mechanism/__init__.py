"""The structure of a mechanism: the Scene, its graph, and the reduced scene that is solved."""
