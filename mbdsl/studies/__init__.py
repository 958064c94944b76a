"""Studies: many runs of one model, to learn something about it that no single run tells. One file each."""
