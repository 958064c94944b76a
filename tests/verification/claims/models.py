"""All claims."""

from __future__ import annotations

import chains
import contacts
import laws
import loops
import mechanisms
import others
import pulses
import reported
import vibrations

MODULES = (pulses, vibrations, contacts, chains, loops, others, reported)  # each adds its own
CLAIMS = {**laws.CLAIMS, **mechanisms.CLAIMS}
