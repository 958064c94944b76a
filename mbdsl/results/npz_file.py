"""NumPy's archive: ``numpy.load("result.npz")["crank.phi"]``; units and meta as JSON text in ``_mbdsl``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

SUFFIX = ".npz"
ABOUT = "_mbdsl"
KEEPS_MODEL = True  #: the meta data may contain the model's text


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    # numpy.savez takes the names as keyword arguments and has an argument "file" itself.
    import zipfile

    import numpy as np

    about = np.array(json.dumps({"names": list(columns), "units": dict(units), "meta": dict(meta)}))
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, values in {**{k: np.asarray(v, dtype=float) for k, v in columns.items()}, ABOUT: about}.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, values, allow_pickle=False)


def read(path: Path) -> tuple[dict, dict]:
    import zipfile

    import numpy as np

    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as archive:
            about = json.loads(archive[ABOUT].item()) if ABOUT in archive.files else {}
            found = {name: archive[name] for name in about.get("names", archive.files)}
            meta = about.get("meta", {"complete": True})
            if not isinstance(meta, dict):
                raise ValueError("its metadata cannot be read")
            # archives of other programs may contain texts and records
            return {name: x for name, x in found.items() if x.dtype.kind in "fiub"}, meta
    except (zipfile.BadZipFile, EOFError) as problem:
        raise ValueError(str(problem)) from problem
