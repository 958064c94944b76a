"""Reports: one page with all that a run of a model shows."""
