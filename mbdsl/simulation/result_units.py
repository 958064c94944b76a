"""Units of result files: columns are read in SI units, and written in others only to .csv files that name them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from mbdsl import results
from mbdsl.errors import UsageError
from mbdsl.lang import display_units, units
from mbdsl.messages import OWN, UnitsOfSignals

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.stored import Result

KEY = "display_units"  #: name of the text in the metadata


class Scaled:
    """A column in another unit; its slices are converted when they are written."""

    def __init__(self, column: Any, factor: float) -> None:
        self._column, self._factor = column, factor

    def __len__(self) -> int:
        return len(self._column)

    def __getitem__(self, rows: slice) -> np.ndarray:
        import numpy as np

        return np.asarray(self._column[rows], float) / self._factor


def check(path: str | PathLike, given: object) -> None:
    """Check that a file is of a format whose numbers may have other units than SI units.

    Raises
    ------
    UsageError
        If it is another one.
    """
    if given and not takes(path):
        suffix = results.format_of(path).SUFFIX
        raise UsageError(f"{suffix} files are in SI units", hint="omit the units, or write .csv, which names its units")


def takes(path: str | PathLike) -> bool:
    """Whether the numbers of a file may have other units than SI units."""
    return hasattr(results.format_of(path), "write_with_units")


def converted(
    path: str | PathLike, columns: Mapping[str, Any], own: Mapping[str, str], display: UnitsOfSignals
) -> tuple[dict[str, Any], dict[str, str]]:
    """Columns and their units as a file has them: in the units that were asked for if its format allows it."""
    display = display_units.only_asked(display) if takes(path) else OWN
    if display is OWN:
        return dict(columns), dict(own)
    shown = {name: display.of(own.get(name, ""), name) for name in columns}
    written = {name: x if shown[name].factor == 1.0 else Scaled(x, shown[name].factor) for name, x in columns.items()}
    return written, {name: unit.symbol for name, unit in shown.items()}


def in_si(result: Result) -> Result:
    """A result file with its columns in SI units; they are displayed in the units that the file names."""
    from mbdsl.results.stored import Layout, of_layout

    layout = result.layout
    declared = display_units.of_text(str(layout.meta.get(KEY, "")), result.names)
    factors = _factors(layout.units)
    if factors:
        declared |= {name: layout.units[name] for name in factors}
        own = {name: display_units.si(unit) if name in factors else unit for name, unit in layout.units.items()}

        def chunks(asked: Sequence[str], rows: int) -> Iterator:
            for part in layout.chunks(asked, rows):
                yield [x * factors[name] if name in factors else x for name, x in zip(asked, part, strict=True)]

        result = of_layout(result, Layout(layout.names, own, chunks, layout.meta))
    result.display = display_units.declare(declared)
    return result


def read(path: str | PathLike) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The columns (N,) of a result file in SI units by their names, and its metadata, as ``mbdsl.results.read``."""
    from mbdsl.results.stored import open_result

    columns, meta = results.read(path)
    factors = _factors(open_result(path).layout.units) if "time" in columns else {}
    return {name: x * factors[name] if name in factors else x for name, x in columns.items()}, meta


def _factors(own: Mapping[str, str]) -> dict[str, float]:
    """The sizes of units that are no SI units, by the names of their signals."""
    found = {name: units.parse(unit) for name, unit in own.items() if unit not in ("", "1")}
    return {name: unit.factor for name, unit in found.items() if unit is not None and unit.factor != 1.0}
