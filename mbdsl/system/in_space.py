"""The parts of the compiled code that differ between the plane and space: names of the buffers, and loops.

Loops are the same source for both. Those in space are a second module of this source, in which names of
:mod:`mbdsl.compilation.buffer_layout` and of :mod:`mbdsl.system.frame_block` are those of their counterparts in space.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from types import ModuleType

from mbdsl.compilation import buffer_layout, buffer_layout_in_space
from mbdsl.system import loops

#: modules with a counterpart in space
COUNTERPARTS = ("mbdsl.compilation.buffer_layout", "mbdsl.system.frame_block")


def layout_of(spatial: bool) -> ModuleType:
    """The names of the buffers' columns and sizes."""
    return buffer_layout_in_space if spatial else buffer_layout


@cache
def loops_of(spatial: bool) -> ModuleType:
    """The module of the loops."""
    return _variant(loops) if spatial else loops


@cache
def relation_loops_of(spatial: bool) -> ModuleType:
    """The module of the loops over constraints by expression; few models need it."""
    from mbdsl.system import relation_loops

    return _variant(relation_loops) if spatial else relation_loops


def _variant(module: ModuleType) -> ModuleType:
    """The module ``<name>_in_space`` from the source of ``module``; its kernels are compiled from the same file."""
    file = Path(str(module.__file__))
    text = file.read_text(encoding="utf-8")
    for name in COUNTERPARTS:
        text = text.replace(f"from {name} import", f"from {name}_in_space import")
    made = ModuleType(f"{module.__name__}_in_space", module.__doc__)
    made.__file__, made.__package__ = str(file), module.__package__
    sys.modules[made.__name__] = made
    exec(compile(text, str(file), "exec"), vars(made))
    return made
