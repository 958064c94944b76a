"""Files of a frequency response: columns, tables, pictures and pages."""

from __future__ import annotations

import csv
import io
import json
import math
from os import PathLike
from typing import TYPE_CHECKING

from mbdsl.analysis import response_tables
from mbdsl.messages import cell
from mbdsl.plotting import pages, signal_plots, table_files
from mbdsl.plotting.figures import Figure, Page, TextTable
from mbdsl.storage.output_files import suffix_of, write_text

if TYPE_CHECKING:
    from mbdsl.analysis.response_results import Response

SUFFIXES = (".csv", ".json", ".md", ".tex", *signal_plots.SUFFIXES)


def save(response: Response, path: str | PathLike) -> None:
    """See :meth:`mbdsl.analysis.response_results.Response.save`."""
    suffix = suffix_of(path, SUFFIXES)
    if suffix == ".csv":
        write_text(path, _csv(response))
    elif suffix == ".json":
        write_text(path, json.dumps(_content(response), indent=2) + "\n")
    elif suffix in (".md", ".tex"):
        table_files.write(path, _tables(response), [], response._head(), response.notes)
    elif suffix == ".html":
        shown = response.plot()
        items: list[Figure | TextTable] = [*shown.panels, *_tables(response)]
        pages.write(Page(shown.title, shown.notes, items, looks=shown.looks), path)
    else:
        response.plot().save(path)


def _tables(response: Response) -> list[TextTable]:
    pairs = [(j, k) for j in range(len(response.outputs)) for k in range(len(response.inputs))]
    return [response.table(), response_tables.values(response, pairs)]


def _csv(response: Response) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    columns = response.to_dict()
    writer.writerow([cell(name) for name in columns])
    writer.writerows(zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True))
    return stream.getvalue()


def _content(response: Response) -> dict:
    """All content; numbers that JSON lacks, such as infinite amplitudes, are null."""
    amplitude, phase = response.amplitude, response.phase
    pairs = []
    for j, output in enumerate(response.outputs):
        for k, name in enumerate(response.inputs):
            said = {"output": output, "input": name, "unit": response.unit(j, k)}
            said |= {"amplitude": amplitude[:, j, k].tolist(), "phase": phase[:, j, k].tolist()}
            pairs.append(said)
    peaks = [{key: _plain(x) for key, x in peak._asdict().items()} for peak in response.peaks]
    modes = [
        {"frequency": mode.frequency, "damping": mode.damping, "bodies": dict(mode.bodies)} for mode in response.modes
    ]
    return {
        "model": response.scene.name,
        "at": response.at,
        "t": response.t,
        "amplitude of inputs": response.amplitude_of_input,
        "frequency": response.f.tolist(),
        "responses": pairs,
        "peaks": peaks,
        "modes": modes,
        "notes": response.notes,
    }


def _plain(x: object) -> object:
    return None if isinstance(x, float) and not math.isfinite(x) else x
