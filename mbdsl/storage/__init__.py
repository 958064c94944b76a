"""Files and folders: written completely or not at all, read only if the user or root owns them, and the cache."""
