"""Files, folders and memory: files are written completely or not at all, and read only if the user or root owns them; the
cache; pauses of the garbage collector."""
