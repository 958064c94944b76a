"""Static equilibrium: pseudo-transient continuation to it, and static shapes of flexible bodies."""
