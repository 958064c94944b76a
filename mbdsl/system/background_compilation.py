"""Compilation of the code of a scene in another process, while this process compiles the step loop.

``main`` performs :func:`mbdsl.system.emit.load` there and stores the result in the cache folder.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from mbdsl.compilation import code_cache
from mbdsl.system.emit import load
from mbdsl.system.structure import Block, kernels_of

if TYPE_CHECKING:
    import subprocess


def start(blocks: list[Block], has_tape: bool, sets: int) -> subprocess.Popen | None:
    """Start compiling a structure in another process; None if no process can be started."""
    roles = [[b.role, b.module.__name__, b.driven] for b in blocks]
    return code_cache.beside(__name__, json.dumps([roles, has_tape, sets]))


def main(structure: str) -> None:
    roles, has_tape, sets = json.loads(structure)
    blocks = [Block(role, kernels_of(module), driven=driven) for role, module, driven in roles]
    load(blocks, has_tape, sets)
