"""All claims."""

from __future__ import annotations

import laws
import mechanisms

CLAIMS = {**laws.CLAIMS, **mechanisms.CLAIMS}
