"""Compiling a scene's code in another process, while this one compiles the step loop.

``main`` does there what :func:`mbdsl.system.emit.load` does, and leaves the result on disk.
"""

from __future__ import annotations

import importlib
import json
import subprocess

from mbdsl import jit
from mbdsl.scene import Component
from mbdsl.system.blocks import Block
from mbdsl.system.emit import load


def start(blocks: list[Block], has_tape: bool, sets: int) -> subprocess.Popen | None:
    """Begin to compile a structure; None where no process can be had."""
    roles = [[b.role, b.name, b.driven] for b in blocks]
    return jit.beside(__name__, json.dumps([roles, has_tape, sets]))


def main(structure: str) -> None:
    roles, has_tape, sets = json.loads(structure)
    blocks = []
    for role, name, driven in roles:
        module = importlib.import_module(f"mbdsl.elements.{name}")
        members = (Component("", module.KIND, {}),) if role != "body" else ()
        blocks.append(Block(role, module, members, driven))
    load(blocks, has_tape, sets)
