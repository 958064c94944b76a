"""The files of a sweep: tables as CSV, Markdown and LaTeX, pictures, and a page with both."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from mbdsl.plotting import table_files
from mbdsl.plotting.signal_plots import SUFFIXES as PICTURES
from mbdsl.storage.output_files import suffix_of

if TYPE_CHECKING:
    from mbdsl.studies.sweep_results import Sweep

SUFFIXES = tuple(dict.fromkeys((*table_files.SUFFIXES, *PICTURES)))


def save(sweep: Sweep, path: str | os.PathLike) -> None:
    """Write the table, the picture or the page of a sweep, as the suffix selects."""
    suffix = suffix_of(path, SUFFIXES)
    if suffix in table_files.SUFFIXES:
        title, *notes = sweep.summary()
        table_files.write(path, [sweep.table()], sweep.records(), title, [note.strip() for note in notes])
    elif suffix == ".html":
        from mbdsl.studies.sweep_figures import write_page

        write_page(sweep, path)
    else:
        sweep.plot().save(path)
