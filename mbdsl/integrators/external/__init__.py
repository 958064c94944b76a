"""The backends of this package, one file each; a file imports its third-party library only when it runs."""
