"""Costs of a run: the effects that a scene needs, and the time of every statement."""
