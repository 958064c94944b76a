"""Files written completely or not at all, trusted files, the cache folder; the garbage collector."""
