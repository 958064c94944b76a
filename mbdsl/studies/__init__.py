"""Studies: several runs of a model, to measure errors, run times and effects. One file a study."""
