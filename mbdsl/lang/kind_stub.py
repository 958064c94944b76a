"""The stub ``kind_methods.pyi``: the methods of the Builder for editors and type checkers.

``python -m mbdsl.lang.kind_stub`` writes it, after a change of a kind.
"""

from __future__ import annotations

import inspect
from pathlib import Path
from textwrap import indent

from mbdsl.elements.kind import Kind
from mbdsl.lang.kind_methods import documentation, known, signature
from mbdsl.storage.output_files import write_text

PATH = Path(__file__).with_name("kind_methods.pyi")
_HEAD = '''"""One method of the Builder for each kind of component: made by ``python -m mbdsl.lang.kind_stub``."""

from inspect import Signature
from typing import Literal

from mbdsl.elements.kind import Kind
from mbdsl.lang.handles import Frames, Handle, Law, Number, Place, Start, Vector

def known() -> dict[str, Kind]: ...
def signature(kind: Kind) -> Signature: ...
def documentation(name: str, kind: Kind) -> str: ...

class KindMethods:
    """The methods of a Builder that add components."""
'''


def stub() -> str:
    """The text of the stub."""
    return "\n".join([_HEAD, *(_method(name, kind) for name, kind in known().items())])


def _method(name: str, kind: Kind) -> str:
    lines, named = [f"    def {name}("], False
    for p in signature(kind).parameters.values():
        if p.kind is inspect.Parameter.VAR_POSITIONAL:
            lines.append(f"        *{p.name}: {p.annotation},")
            named = True
            continue
        if p.kind is inspect.Parameter.KEYWORD_ONLY and not named:
            lines.append("        *,")
            named = True
        annotation = "" if p.annotation is p.empty else f": {p.annotation}"
        default = "" if p.default is p.empty else " = " + repr(p.default).replace("'", '"')
        lines.append(f"        {p.name}{annotation}{default},")
    doc = documentation(name, kind).replace("\\", "\\\\")
    return "\n".join([*lines, "    ) -> Handle:", indent(f'"""{doc}\n"""', " " * 8), ""])


if __name__ == "__main__":
    write_text(PATH, stub())
