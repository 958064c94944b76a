"""mbdsl linearise: the matrices A, B, C, D of a model about a state."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say
from mbdsl.storage.output_files import suffix_of, write_text, writing

if TYPE_CHECKING:
    from mbdsl.analysis.linearisation import Linearisation
    from mbdsl.plotting.figures import TextTable

TABLES = (".md", ".tex")
SUFFIXES = (".json", ".mat", ".npz", *TABLES)


COMMAND = Command(
    "linear state-space model: A, B, C, D about a state",
    "Linearise a model about a state in minimal coordinates; print names, units and the matrices of x' = A x + B u, y"
    " = C x + D u, for deviations x, u and y from that state.",
    """
    @model at
    --inputs NAME,...  inputs u, or forces such as push.fx; default: all inputs of the model
    --signals NAME,...  outputs y, such as pin.phi; default: the states
    --output FILE  write matrices, names and units (.json, .mat, .npz, or as tables .md, .tex)
    """,
    inputs=values.names,
    signals=values.patterns,
)


def run(args: argparse.Namespace) -> int:
    if args.output:
        suffix_of(args.output, SUFFIXES)
    scene = values.load_for(args, [args.output])

    from mbdsl.analysis.linearisation import linearise

    found = linearise(scene, args.at, args.inputs, args.signals, announce=say)
    print(found)
    if args.output:
        write(found, args.output)
        print(f"{args.output}: A, B, C, D, with names, units and values at the state")
    return 0


def write(found: Linearisation, path: str) -> None:
    """All content of a linear model: lists in JSON; arrays in .npz and in .mat files of MATLAB and Octave; tables."""
    import numpy as np

    content = found.to_dict()
    suffix = Path(path).suffix.lower()
    if suffix in TABLES:
        from mbdsl.plotting import table_files

        table_files.write(path, _tables(found), [], str(found).partition("\n")[0], found.notes)
        return
    if suffix == ".json":
        plain = {key: _plain(x.tolist()) if isinstance(x, np.ndarray) else x for key, x in content.items()}
        write_text(path, json.dumps(plain, indent=2) + "\n")
        return
    with writing(path) as stream:
        if suffix == ".npz":
            arrays: dict[str, Any] = {key: np.asarray(x) for key, x in content.items()}
            np.savez(stream, **arrays)
        else:
            from scipy.io import savemat

            cells = {key: np.array(x, dtype=object) if isinstance(x, list) else x for key, x in content.items()}
            savemat(stream, cells)


def _tables(found: Linearisation) -> list[TextTable]:
    """Vectors with units and values, and the matrices with the names of rows and columns, as tables for files."""
    import numpy as np

    from mbdsl.analysis.linear_tables import clean
    from mbdsl.plotting.figures import TextTable

    vectors = (
        ("x", found.states, found.state_units, found.x0),
        ("u", found.inputs, found.input_units, found.u0),
        ("y", found.outputs, found.output_units, found.y0),
    )
    tables = []
    for letter, names, units, now in vectors:
        rows = [
            (f"{letter}{k}", name, "" if np.isnan(x) else f"{x:.10g}", unit)
            for k, (name, unit, x) in enumerate(zip(names, units, now, strict=True), 1)
        ]
        tables.append(TextTable(f"Vector {letter}", ("", "name", "value", "unit"), rows))
    rates = [f"{name}'" for name in found.states]
    matrices = (
        ("A", found.A, rates, found.states),
        ("B", found.B, rates, found.inputs),
        ("C", found.C, found.outputs, found.states),
        ("D", found.D, found.outputs, found.inputs),
    )
    for letter, matrix, left, above in matrices:
        rows = [(name, *(f"{x:.10g}" for x in row)) for name, row in zip(left, clean(matrix), strict=True)]
        tables.append(TextTable(f"Matrix {letter}", ("", *above), rows if above else []))
    return tables


def _plain(x):
    """Numbers for JSON, which has no nan."""
    if isinstance(x, list):
        return [_plain(part) for part in x]
    return x if x == x else None
