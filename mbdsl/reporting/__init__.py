"""Reports: one page about a model and its run."""
