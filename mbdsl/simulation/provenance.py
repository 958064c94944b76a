"""The code, versions and machine that a result was computed with."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import cache
from pathlib import Path

import numpy as np

from mbdsl import elements
from mbdsl.version import __version__


@cache
def code() -> str:
    """Digest of the source files of mbdsl that affect results, and of the versions of its dependencies."""
    digest = hashlib.sha256(f"{sorted(versions().items())} {sys.version}".encode())
    for path in _sources():
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _sources() -> list[Path]:
    package = Path(__file__).parents[1]
    about = [package / "studies" / name for name in ("cases.py", "compute.py")]  # these identify a run
    apart = ("cli", "plotting", "reporting", "results", "studies", "viewing")
    own = [p for p in sorted(package.rglob("*.py")) if p.relative_to(package).parts[0] not in apart]
    kinds = (Path(str(module.__file__)) for module in elements.modules().values())
    return about + own + sorted(p for p in kinds if package not in p.parents)  # kinds may be defined by third parties


def versions() -> dict[str, str]:
    """The versions that results depend on."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"mbdsl": __version__, "python": platform.python_version(), "numpy": np.__version__}
    for name in ("scipy", "llvmlite", "scikit-sundae"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


@cache
def machine() -> dict[str, str]:
    """The properties of the machine that times depend on."""
    from mbdsl.compilation import code_cache

    processor = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        processor = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "processor": processor,
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.machine()}",
        "compiled": "yes" if code_cache.enabled() else "no",
        "host": platform.node(),
    }
