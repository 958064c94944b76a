"""The stubs ``kind_methods.pyi`` and ``spatial_builder.pyi``: methods of the Builders, for editors and type checkers.

They are written when mbdsl is built or installed, by ``hatch_build.py``; after a change of a kind
``python -m mbdsl.lang.builder.kind_stub`` writes them again.
"""

from __future__ import annotations

import inspect
from pathlib import Path
from textwrap import indent

from mbdsl.elements.kind import Kind
from mbdsl.lang.builder.kind_methods import documentation, known, missing, signature
from mbdsl.lang.builder.spatial_builder import SpatialBuilder
from mbdsl.storage.output_files import write_text

PATH = Path(__file__).with_name("kind_methods.pyi")
PATH_IN_SPACE = Path(__file__).with_name("spatial_builder.pyi")
_HEAD = '''"""One method of the Builder for each kind of component: made when mbdsl is built or installed."""

from inspect import Signature
from typing import Literal

from mbdsl.elements.kind import Kind
from mbdsl.lang.builder.handles import Frames, Handle, Law, Number, Place, Places, StartValue, Vector

def known(spatial: bool = False) -> dict[str, Kind]: ...
def missing(spatial: bool) -> list[str]: ...
def add_methods(to: type, spatial: bool = False) -> None: ...
def signature(kind: Kind) -> Signature: ...
def documentation(name: str, kind: Kind) -> str: ...

class KindMethods:
    """The methods of a Builder that add components."""
'''

_HEAD_IN_SPACE = '''"""The Builder of models in space: made when mbdsl is built or installed."""

from typing import Literal

from mbdsl.lang.builder.builder import Builder
from mbdsl.lang.builder.handles import Frames, Handle, Law, Number, Place, Places, StartValue, Vector

class SpatialBuilder(Builder):
    """Collects the components of a model in space and makes a ``Scene`` of them."""
'''


def stub() -> str:
    """The text of the stub of the methods in the plane."""
    return "\n".join([_HEAD, *(_method(name, kind) for name, kind in known().items())])


def stub_in_space() -> str:
    """The text of the stub of the methods in space."""
    none = "".join(f"    {name}: None  # type: ignore[assignment]\n" for name in missing(spatial=True))
    of_frame = inspect.signature(SpatialBuilder.frame), inspect.getdoc(SpatialBuilder.frame) or ""
    methods = (_method(name, kind) for name, kind in known(spatial=True).items())
    return "\n".join([_HEAD_IN_SPACE, _declared("frame", *of_frame, True), none, *methods])


def _method(name: str, kind: Kind) -> str:
    return _declared(name, signature(kind), documentation(name, kind), kind.spatial)


def _declared(name: str, signature: inspect.Signature, doc: str, overrides: bool) -> str:
    """The declaration of a method that returns a handle."""
    lines, named = [f"    def {name}({'  # type: ignore[override]' if overrides else ''}"], False
    for p in signature.parameters.values():
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
    doc = doc.replace("\\", "\\\\")
    return "\n".join([*lines, "    ) -> Handle:", indent(f'"""{doc}\n"""', " " * 8), ""])


def write() -> None:
    """Write both stubs beside this file."""
    write_text(PATH, stub())
    write_text(PATH_IN_SPACE, stub_in_space())


if __name__ == "__main__":
    write()
